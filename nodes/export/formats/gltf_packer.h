// A glTF model with one buffer that is filled piece by piece. Lengths, axes and colors: see gltf.h.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/shapes.h"
#include "nodes/export/formats/units.h"

namespace terrazzo::exporting {

// The rotation by −90° about x that turns z up into y up.
inline Vec3 y_up(const Vec3& v) { return {v.x(), v.z(), -v.y()}; }

class GltfPacker {
 public:
  GltfPacker();

  // Appends an accessor and returns its index: `components` floats per element. `target`:
  // TINYGLTF_TARGET_ARRAY_BUFFER, or 0 for instance data. `bounds`: with the smallest and largest values.
  int floats(const std::vector<float>& data, int components, int target, bool bounds = false);
  // A rough, not metallic material of that scene-linear color.
  int material(const std::string& name, const Vec3f& color);
  // The shape's triangles with their normals, in meters and with y up. With `textured`, the shape's texture
  // coordinates, else its colors (COLOR_0), if it has any.
  tinygltf::Primitive primitive(const Shape&, bool textured = false);
  // A rough, not metallic material with that texture, as a PNG image inside the file.
  int textured_material(const std::string& name, const Image& texture);
  // A texture of a PNG file's bytes.
  int texture(const std::string& name, const std::string& png);
  int mesh(const std::string& name, const tinygltf::Primitive&);
  int node(tinygltf::Node);
  // Adds a node to the scene.
  void root(int node) { model.scenes[0].nodes.push_back(node); }
  // `provenance`: a JSON object for asset.extras, or empty. Throws Error "write-failed", "too-large" if the
  // file exceeds 4 GiB.
  void write(const std::filesystem::path&, const std::string& provenance);

  tinygltf::Model model;

 private:
  int triangles(const std::vector<std::uint32_t>& indices, std::size_t vertices);
  int view(const void* data, std::size_t size, int target);
  int add(tinygltf::Accessor a);
};

}  // namespace terrazzo::exporting
