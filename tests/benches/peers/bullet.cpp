// HANG and DRAPE in Bullet's soft bodies (Debian's libbullet-dev), a row a level: see README.md beside this file.
#include <btBulletDynamicsCommon.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

// Distance from the held edge and height of each row, by number of particles and tenth of a second.
using Exact = std::map<std::pair<int, int>, std::vector<std::pair<double, double>>>;

static Exact read_exact(const char *path) {
    Exact exact;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        if (line.empty() || !std::isdigit(line[0])) continue;
        std::replace(line.begin(), line.end(), ',', ' ');
        std::istringstream row(line);
        int n, at;
        double t, out, y;
        row >> n >> t >> at >> out >> y;
        exact[{n, int(std::lround(10 * t))}].push_back({out, y});
    }
    return exact;
}

static void run(const char *scene, int n, int substeps, int iterations, const Exact &exact) {
    const bool hang = std::string(scene) == "HANG";
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.setGravity({0, -9.81, 0});
    world.getWorldInfo().m_gravity.setValue(0, -9.81, 0);
    world.getWorldInfo().m_sparsesdf.Initialize();
    const btScalar half = hang ? 0.5 : 1.0, z0 = hang ? 0.0 : -1.0, y0 = hang ? 0.0 : 0.6;
    btSoftBody *cloth = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), {-half, y0, z0}, {half, y0, z0},
                                                       {-half, y0, z0 + 2 * half}, {half, y0, z0 + 2 * half}, n, n, hang ? 1 + 2 : 0, true);
    cloth->m_materials[0]->m_kLST = 1;
    cloth->m_cfg.piterations = iterations;
    cloth->m_cfg.kDP = 0;
    cloth->m_cfg.kDF = 0.5;
    // The default of 0.25 m would hold the cloth as far off.
    cloth->getCollisionShape()->setMargin(0);
    cloth->m_cfg.collisions = btSoftBody::fCollision::SDF_RS;
    cloth->setTotalMass(0.2 * 4 * half * half);
    if (hang) {
        cloth->setMass(0, 0);
        cloth->setMass(n - 1, 0);
    }
    world.addSoftBody(cloth);
    btSphereShape ball(0.5);
    btDefaultMotionState still;
    btRigidBody body(0, &still, &ball);
    body.setFriction(0.5);
    if (!hang) world.addRigidBody(&body);

    std::vector<double> times;
    double square = 0, p99 = 0, depth = 0;
    for (int frame = 1; frame <= 180; frame++) {
        auto start = std::chrono::steady_clock::now();
        for (int s = 0; s < substeps; s++) world.stepSimulation(1.0 / 60 / substeps, 0, 1.0 / 60 / substeps);
        times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
        auto at = [&](int row, int column) { return cloth->m_nodes[row * n + column].m_x; };
        if (hang && frame % 6 == 0 && frame <= 36) {
            auto rows = exact.find({n, frame / 6});
            double sum = 0;
            for (int r = 0; rows != exact.end() && r < n; r++)
                for (int c = 0; c < n; c++) {
                    btVector3 p = at(r, c);
                    double x = double(c) / (n - 1) - 0.5;
                    sum += std::pow(p.x() - x, 2) + std::pow(p.y() - rows->second[r].second, 2) + std::pow(p.z() - rows->second[r].first, 2);
                }
            square += sum / (n * n) / 6;
        }
        if (frame % 60 == 0) {
            std::vector<double> strains;
            const double rest = 2.0 * half / (n - 1);
            for (int r = 0; r < n; r++)
                for (int c = 0; c < n; c++) {
                    if (c + 1 < n) strains.push_back((at(r, c + 1) - at(r, c)).length() / rest - 1);
                    if (r + 1 < n) strains.push_back((at(r + 1, c) - at(r, c)).length() / rest - 1);
                }
            std::sort(strains.begin(), strains.end());
            p99 = std::max(p99, 100 * strains[strains.size() * 99 / 100]);
        }
        if (!hang)
            for (int i = 0; i < n * n; i++) depth = std::max(depth, 1e3 * (0.5 - cloth->m_nodes[i].m_x.length()));
    }
    std::sort(times.begin(), times.end());
    std::printf("Bullet,s%dp%d,%s,%d,%.4g,%.4g,%s,%.4g\n", substeps, iterations, scene, n, times[90], p99,
                hang ? std::to_string(1e3 * std::sqrt(square)).c_str() : "", depth);
    std::fflush(stdout);
    if (!hang) world.removeRigidBody(&body);
    world.removeSoftBody(cloth);
    delete cloth;
}

int main(int, char **arguments) {
    const Exact exact = read_exact(arguments[1]);
    for (const char *scene : {"HANG", "DRAPE"})
        for (int n : {32, 64})
            for (auto [substeps, iterations] : {std::pair{1, 5}, {1, 20}, {4, 5}, {4, 20}, {10, 10}}) run(scene, n, substeps, iterations, exact);
}
