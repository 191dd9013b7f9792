#include "nodes/export/formats/pbrt_file.h"

#include <fmt/format.h>

#include "nodes/common/io/checked_file.h"

namespace terrazzo::exporting {
namespace {

std::string three(const Vec3& v) { return fmt::format("{} {} {}", v.x(), v.y(), v.z()); }
std::string rgb(const Vec3f& c) { return fmt::format("{} {} {}", c.x(), c.y(), c.z()); }

void write_binder(std::ostream& out, const Scene& s) {
  const VoxelBox& box = s.binder->box;
  const Vec3 lo = box.corner, hi = lo + box.size.cast<double>().cwiseProduct(box.spacing);
  const Vec3f albedo = s.particles->binder_color.cwiseMax(0).cwiseMin(1);
  out << fmt::format(
      "# Binder. scale: extinction per mm where no particle is.\n"
      "MakeNamedMedium \"binder\" \"string type\" \"nanovdb\" \"string filename\" \"{}\"\n"
      "  \"rgb sigma_s\" [ {} ] \"rgb sigma_a\" [ {} ] \"float scale\" {}\n"
      "AttributeBegin\n  MediumInterface \"binder\" \"\"\n  Material \"interface\"\n"
      "  Shape \"trianglemesh\"\n    \"integer indices\" [ 0 2 1 1 2 3 4 5 6 5 7 6 0 1 4 1 5 4 2 6 3 3 6 7 0 "
      "4 2 2 4 6 "
      "1 3 5 3 7 5 ]\n    \"point3 P\" [",
      s.binder_file, rgb(albedo), rgb(Vec3f::Ones() - albedo), s.binder->extinction);
  for (int k = 0; k < 8; ++k)
    out << "  " << three(Vec3(k & 1 ? hi.x() : lo.x(), k & 2 ? hi.y() : lo.y(), k & 4 ? hi.z() : lo.z()));
  out << " ]\nAttributeEnd\n";
}

}  // namespace

void write_pbrt(const std::filesystem::path& path, const Scene& s, const Work& work) {
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    out << "# Terrazzo, for pbrt-v4. Lengths in mm, z up, colors linear.\n";
    if (!s.provenance.empty()) {
      std::string line = s.provenance;
      std::erase_if(line, [](char c) { return c == '\n' || c == '\r'; });
      out << "# provenance " << line << "\n";
    }
    out << fmt::format(
        "Scale -1 1 1\nLookAt {}  {}  0 0 1\nCamera \"perspective\" \"float fov\" {}\n"
        "Sampler \"zsobol\" \"integer pixelsamples\" {}\nIntegrator \"volpath\"\n"
        "Film \"rgb\" \"integer xresolution\" {} \"integer yresolution\" {} \"string filename\" \"{}.exr\"\n"
        "WorldBegin\nLightSource \"infinite\" \"rgb L\" [ 1 1 1 ]\n",
        three(s.eye()), three(s.center()), kSceneViewAngle, kSceneSamples, kSceneWidth, kSceneHeight,
        "render");
    for (std::size_t c = 0; c < s.colors.size(); ++c)
      out << fmt::format(
          "MakeNamedMaterial \"color_{}\" \"string type\" \"diffuse\" \"rgb reflectance\" [ {} ]\n", c,
          rgb(s.colors[c]));
    for (std::size_t g = 0; g < s.groups.size(); ++g)
      out << fmt::format(
          "ObjectBegin \"group_{}\"\n  NamedMaterial \"color_{}\"\n"
          "  Shape \"plymesh\" \"string filename\" \"{}\"\nObjectEnd\n",
          g, s.groups[g].color, s.mesh_files[s.groups[g].shape]);
    if (s.binder) write_binder(out, s);
    for (std::size_t i = 0; i < s.particles->count(); ++i) {
      if (i % 4096 == 0) {
        work.check();
        work.done(i, s.particles->count());
      }
      if (s.group[i] < 0) continue;
      const auto m = instance_matrix(*s.particles, i);
      out << "AttributeBegin\n  Transform [";
      for (std::size_t c = 0; c < 4; ++c)
        for (std::size_t r = 0; r < 4; ++r) out << fmt::format(" {}", m[4 * r + c]);  // by column
      out << fmt::format(" ]\n  ObjectInstance \"group_{}\"\nAttributeEnd\n", s.group[i]);
    }
  });
}

}  // namespace terrazzo::exporting
