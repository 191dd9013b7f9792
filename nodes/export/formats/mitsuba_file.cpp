#include "nodes/export/formats/mitsuba_file.h"

#include <fmt/format.h>

#include "graph/text/escape_xml.h"
#include "nodes/common/io/checked_file.h"
#include "runtime/files/base64.h"

namespace terrazzo::exporting {
namespace {

std::string comma_separated(const Vec3& v) { return fmt::format("{}, {}, {}", v.x(), v.y(), v.z()); }
std::string comma_separated_color(const Vec3f& c) { return fmt::format("{}, {}, {}", c.x(), c.y(), c.z()); }

void write_binder_shape(std::ostream& out, const Scene& s) {
  const VoxelBox& box = s.binder->box;
  const Vec3 size = box.size.cast<double>().cwiseProduct(box.spacing);
  out << fmt::format(
      "  <!-- Binder. scale: extinction per mm where no particle is. -->\n"
      "  <medium type=\"heterogeneous\" id=\"binder\">\n"
      "    <volume name=\"sigma_t\" type=\"gridvolume\">\n"
      "      <string name=\"filename\" value=\"{0}\"/>\n"
      "      <transform name=\"to_world\">\n        <scale value=\"{1}\"/>\n        <translate "
      "value=\"{2}\"/>\n"
      "      </transform>\n    </volume>\n"
      "    <rgb name=\"albedo\" value=\"{3}\"/>\n    <float name=\"scale\" value=\"{4}\"/>\n  </medium>\n"
      "  <shape type=\"cube\" id=\"box\">\n"
      "    <transform name=\"to_world\">\n      <scale value=\"{5}\"/>\n      <translate value=\"{6}\"/>\n"
      "    </transform>\n    <bsdf type=\"null\"/>\n    <ref name=\"interior\" id=\"binder\"/>\n  </shape>\n",
      escape_xml(s.binder_file), comma_separated(size), comma_separated(box.corner),
      comma_separated_color(s.particles->binder_color), s.binder->extinction, comma_separated(size / 2),
      comma_separated(box.corner + size / 2));
}

}  // namespace

void write_mitsuba(const std::filesystem::path& path, const Scene& s, const Work& work) {
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    out << "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n";
    out << "<!-- Terrazzo, for Mitsuba 3. Lengths in mm, z up, colors linear. -->\n";
    if (!s.provenance.empty()) out << "<!-- provenance " << encode_base64(s.provenance) << " -->\n";
    out << fmt::format(
        "<scene version=\"3.0.0\">\n"
        "  <integrator type=\"{}\"/>\n"
        "  <sensor type=\"perspective\">\n"
        "    <float name=\"fov\" value=\"{}\"/>\n"
        "    <string name=\"fov_axis\" value=\"smaller\"/>\n"
        "    <transform name=\"to_world\">\n"
        "      <lookat origin=\"{}\" target=\"{}\" up=\"0, 0, 1\"/>\n"
        "    </transform>\n"
        "    <film type=\"hdrfilm\">\n"
        "      <integer name=\"width\" value=\"{}\"/>\n"
        "      <integer name=\"height\" value=\"{}\"/>\n"
        "    </film>\n"
        "    <sampler type=\"independent\">\n"
        "      <integer name=\"sample_count\" value=\"{}\"/>\n"
        "    </sampler>\n"
        "  </sensor>\n"
        "  <emitter type=\"constant\"/>\n",
        s.binder ? "volpath" : "path", kSceneViewAngle, comma_separated(s.eye()), comma_separated(s.center()),
        kSceneWidth, kSceneHeight, kSceneSamples);
    for (std::size_t c = 0; c < s.colors.size(); ++c)
      out << fmt::format(
          "  <bsdf type=\"diffuse\" id=\"color_{}\">\n    <rgb name=\"reflectance\" value=\"{}\"/>\n  "
          "</bsdf>\n",
          c, comma_separated_color(s.colors[c]));
    for (std::size_t g = 0; g < s.groups.size(); ++g)
      out << fmt::format(
          "  <shape type=\"shapegroup\" id=\"group_{}\">\n    <shape type=\"ply\">\n"
          "      <string name=\"filename\" value=\"{}\"/>\n      <ref id=\"color_{}\"/>\n    </shape>\n"
          "  </shape>\n",
          g, escape_xml(s.mesh_files[s.groups[g].shape]), s.groups[g].color);
    if (s.binder) write_binder_shape(out, s);
    for (std::size_t i = 0; i < s.particles->count(); ++i) {
      if (i % 4096 == 0) {
        work.check();
        work.done(i, s.particles->count());
      }
      if (s.group[i] < 0) continue;
      out << fmt::format(
          "  <shape type=\"instance\" id=\"particle_{}\"><ref id=\"group_{}\"/><transform name=\"to_world\">"
          "<matrix value=\"{}\"/></transform></shape>\n",
          i, s.group[i], fmt::join(instance_matrix(*s.particles, i), " "));
    }
    out << "</scene>\n";
  });
}

void write_mitsuba_volume(const std::filesystem::path& path, const BinderMedium& binder) {
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    const auto put = [&](const auto& v) { out.write(reinterpret_cast<const char*>(&v), sizeof v); };
    out.write("VOL\x03", 4);
    const VoxelBox& box = binder.box;
    for (const std::int32_t v : {1, box.size.x(), box.size.y(), box.size.z(), 1})
      put(v);                                                           // float32, size, channels
    for (const float v : {0.0f, 0.0f, 0.0f, 1.0f, 1.0f, 1.0f}) put(v);  // the scene places it
    out.write(reinterpret_cast<const char*>(binder.density.data()), binder.density.size() * sizeof(float));
  });
}

}  // namespace terrazzo::exporting
