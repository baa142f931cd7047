//! Writes a binary glTF file.

use bevy::{
    mesh::{Indices, VertexAttributeValues},
    prelude::*,
};
use gltf::{
    binary::{Glb, Header},
    json::{
        Accessor, Asset, Buffer, Index, Root, Value,
        accessor::{ComponentType, GenericComponentType, Type},
        animation::{Animation, Channel, Interpolation, Property, Sampler, Target},
        buffer::View,
        material::{Material, PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor},
        mesh::{Mode, Primitive, Semantic},
        scene::{Node, Scene, UnitQuaternion},
        skin::Skin,
        validation::{Checked::Valid, USize64},
    },
};
use std::{borrow::Cow, collections::BTreeMap};

/// A file that is being put together.
#[derive(Default)]
pub struct Writer {
    root: Root,
    bytes: Vec<u8>,
    /// Nodes that nothing is above.
    tops: Vec<Index<Node>>,
}

/// How an animation moves a joint.
pub struct Keys {
    pub joint: Index<Node>,
    pub rotations: Vec<Quat>,
    pub translations: Vec<Vec3>,
}

impl Writer {
    /// Joints at places in their parents' frames.
    pub fn joints(
        &mut self,
        names: &[&str],
        parents: &[Option<usize>],
        poses: &[Isometry3d],
    ) -> Vec<Index<Node>> {
        let node = |(name, pose): (&&str, &Isometry3d)| Node {
            name: Some((*name).into()),
            translation: Some(pose.translation.into()),
            rotation: Some(UnitQuaternion(pose.rotation.to_array())),
            ..default()
        };
        let joints: Vec<_> = names.iter().zip(poses).map(|it| self.root.push(node(it))).collect();
        for (joint, parent) in joints.iter().zip(parents) {
            match parent {
                Some(parent) => {
                    let parent = &mut self.root.nodes[joints[*parent].value()];
                    parent.children.get_or_insert_default().push(*joint);
                }
                None => self.tops.push(*joint),
            }
        }
        joints
    }

    /// A skin that is bound to joints where they are in these poses of the file's frame.
    pub fn skin(&mut self, joints: &[Index<Node>], poses: &[Isometry3d]) -> Index<Skin> {
        let inverse = |pose: &Isometry3d| {
            let back = pose.inverse();
            Mat4::from_rotation_translation(back.rotation, back.translation.into()).to_cols_array()
        };
        let inverses: Vec<[f32; 16]> = poses.iter().map(inverse).collect();
        let inverses = self.accessor(&inverses, ComponentType::F32, Type::Mat4);
        self.root.push(Skin {
            inverse_bind_matrices: Some(inverses),
            joints: joints.to_vec(),
            skeleton: None,
            name: None,
            extensions: None,
            extras: default(),
        })
    }

    /// A material without shine.
    pub fn material(&mut self, name: &str, color: Srgba, double_sided: bool) -> Index<Material> {
        let color = LinearRgba::from(color).to_f32_array();
        self.root.push(Material {
            name: Some(name.into()),
            double_sided,
            pbr_metallic_roughness: PbrMetallicRoughness {
                base_color_factor: PbrBaseColorFactor(color),
                metallic_factor: StrengthFactor(0.0),
                roughness_factor: StrengthFactor(0.7),
                ..default()
            },
            ..default()
        })
    }

    /// A skinned mesh, on a node of the same name.
    pub fn skinned(
        &mut self,
        name: &str,
        mesh: &Mesh,
        material: Index<Material>,
        skin: Index<Skin>,
    ) {
        let mut attributes = BTreeMap::new();
        for (attribute, semantic) in [
            (Mesh::ATTRIBUTE_POSITION, Semantic::Positions),
            (Mesh::ATTRIBUTE_NORMAL, Semantic::Normals),
            (Mesh::ATTRIBUTE_COLOR, Semantic::Colors(0)),
            (Mesh::ATTRIBUTE_JOINT_INDEX, Semantic::Joints(0)),
            (Mesh::ATTRIBUTE_JOINT_WEIGHT, Semantic::Weights(0)),
        ] {
            let is_place = attribute.id == Mesh::ATTRIBUTE_POSITION.id;
            let Some(values) = mesh.attribute(attribute) else { continue };
            let accessor = match values {
                VertexAttributeValues::Float32x3(values) => {
                    let accessor = self.accessor(values, ComponentType::F32, Type::Vec3);
                    if is_place {
                        self.bound(accessor, values);
                    }
                    accessor
                }
                VertexAttributeValues::Float32x4(values) => {
                    self.accessor(values, ComponentType::F32, Type::Vec4)
                }
                VertexAttributeValues::Uint16x4(values) => {
                    self.accessor(values, ComponentType::U16, Type::Vec4)
                }
                _ => continue,
            };
            attributes.insert(Valid(semantic), accessor);
        }
        let indices = match mesh.indices() {
            Some(Indices::U32(indices)) => {
                let indices: Vec<[u32; 1]> = indices.iter().map(|it| [*it]).collect();
                Some(self.accessor(&indices, ComponentType::U32, Type::Scalar))
            }
            _ => None,
        };
        let primitive = Primitive {
            attributes,
            indices,
            material: Some(material),
            mode: Valid(Mode::Triangles),
            targets: None,
            extensions: None,
            extras: default(),
        };
        let mesh = self.root.push(gltf::json::Mesh {
            name: Some(name.into()),
            primitives: vec![primitive],
            weights: None,
            extensions: None,
            extras: default(),
        });
        let (mesh, skin) = (Some(mesh), Some(skin));
        let node = self.root.push(Node { name: Some(name.into()), mesh, skin, ..default() });
        self.tops.push(node);
    }

    /// An animation of joints, all of them at the same times \[s\].
    pub fn animation(&mut self, name: &str, times: &[f32], keys: impl IntoIterator<Item = Keys>) {
        let times: Vec<[f32; 1]> = times.iter().map(|it| [*it]).collect();
        let input = self.accessor(&times, ComponentType::F32, Type::Scalar);
        self.bound(input, &times);
        let (mut channels, mut samplers) = (Vec::new(), Vec::new());
        for Keys { joint, rotations, translations } in keys {
            let rotations: Vec<_> = rotations.iter().map(|it| it.to_array()).collect();
            let translations: Vec<_> = translations.iter().map(Vec3::to_array).collect();
            let rotations = self.accessor(&rotations, ComponentType::F32, Type::Vec4);
            let translations = self.accessor(&translations, ComponentType::F32, Type::Vec3);
            for (path, output) in
                [(Property::Rotation, rotations), (Property::Translation, translations)]
            {
                let interpolation = Valid(Interpolation::Linear);
                let sampler =
                    Sampler { input, output, interpolation, extensions: None, extras: default() };
                channels.push(Channel {
                    sampler: Index::push(&mut samplers, sampler),
                    target: Target {
                        node: joint,
                        path: Valid(path),
                        extensions: None,
                        extras: default(),
                    },
                    extensions: None,
                    extras: default(),
                });
            }
        }
        self.root.push(Animation {
            name: Some(name.into()),
            channels,
            samplers,
            extensions: None,
            extras: default(),
        });
    }

    /// The file, with all that has no parent in one scene.
    pub fn write(mut self, name: &str) -> Vec<u8> {
        self.root.asset = Asset { generator: Some("bevy_drape's examples".into()), ..default() };
        self.root.push(Buffer {
            byte_length: USize64::from(self.bytes.len()),
            name: None,
            uri: None,
            extensions: None,
            extras: default(),
        });
        let scene = self.root.push(Scene {
            name: Some(name.into()),
            nodes: self.tops,
            extensions: None,
            extras: default(),
        });
        self.root.scene = Some(scene);
        let json = gltf::json::serialize::to_vec(&self.root).expect("numbers and names are JSON");
        let header = Header { magic: *b"glTF", version: 2, length: 0 };
        let glb = Glb { header, json: Cow::Owned(json), bin: Some(Cow::Owned(self.bytes)) };
        glb.to_vec().expect("a file of less than 4 GiB can be written")
    }

    /// Appends data.
    fn accessor<const N: usize, T: Number>(
        &mut self,
        values: &[[T; N]],
        component: ComponentType,
        type_: Type,
    ) -> Index<Accessor> {
        let start = self.bytes.len();
        values.iter().flatten().for_each(|value| value.append(&mut self.bytes));
        let view = self.root.push(View {
            buffer: Index::new(0),
            byte_length: USize64::from(self.bytes.len() - start),
            byte_offset: Some(USize64::from(start)),
            byte_stride: None,
            name: None,
            target: None,
            extensions: None,
            extras: default(),
        });
        self.root.push(Accessor {
            buffer_view: Some(view),
            byte_offset: None,
            count: USize64::from(values.len()),
            component_type: Valid(GenericComponentType(component)),
            type_: Valid(type_),
            min: None,
            max: None,
            name: None,
            normalized: false,
            sparse: None,
            extensions: None,
            extras: default(),
        })
    }

    /// Tells the least and the largest values, where the format wants them.
    fn bound<const N: usize>(&mut self, accessor: Index<Accessor>, values: &[[f32; N]]) {
        let fold = |start: f32, choose: fn(f32, f32) -> f32| {
            let of = |axis: usize| values.iter().fold(start, |sum, value| choose(sum, value[axis]));
            Some(Value::from((0..N).map(of).collect::<Vec<f32>>()))
        };
        let accessor = &mut self.root.accessors[accessor.value()];
        accessor.min = fold(f32::INFINITY, f32::min);
        accessor.max = fold(f32::NEG_INFINITY, f32::max);
    }
}

/// A number of a buffer: little-endian, as glTF has it.
trait Number {
    fn append(&self, bytes: &mut Vec<u8>);
}

impl Number for f32 {
    fn append(&self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }
}

impl Number for u32 {
    fn append(&self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }
}

impl Number for u16 {
    fn append(&self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }
}
