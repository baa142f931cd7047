#!/usr/bin/env bash
# Measures bevy_silk and Bullet beside bevy_drape, one after another on this machine: see README.md.
set -euo pipefail
cd "$(dirname "$0")"
exact="$PWD/../../data/hang_exact.csv"
built="${TMPDIR:-/tmp}/bevy_drape_peers"
mkdir -p "$built"

echo "== the yardstick"
c++ -O3 -march=native -ffast-math -o "$built/yardstick" yardstick.cpp
"$built/yardstick"

echo "== Bullet: peer, substeps and iterations, scene, n, ms a frame, p99 strain %, RMS mm, depth mm"
if pkg-config --exists bullet; then
    read -ra flags <<<"$(pkg-config --cflags --libs bullet)"
    c++ -O3 -o "$built/bullet" bullet.cpp "${flags[@]}"
    "$built/bullet" "$exact"
else
    echo "not installed: apt-get install libbullet-dev"
fi

echo "== bevy_silk: the same"
CARGO_TARGET_DIR="$built/target" cargo run --quiet --release --manifest-path bevy_silk/Cargo.toml -- "$exact"

echo "== bevy_drape"
cd ../../..
cargo run --quiet --release --example speed_vs_error -- --scenes hang,drape
