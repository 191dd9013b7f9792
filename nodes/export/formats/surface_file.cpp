#include "nodes/export/formats/surface_file.h"

#include <fmt/format.h>

#include <array>
#include <map>

#include "graph/diagnostic.h"
#include "nodes/common/io/checked_file.h"

namespace terrazzo::exporting {
namespace {

constexpr const char* kSides[] = {"X0", "X1", "Y0", "Y1", "Z0", "Z1"};
constexpr int kTriangle = 2, kTags = 2;  // of an element in a .msh file

const Region& region_of(const Regions& regions, std::int32_t number) { return regions.all[number]; }

std::string patch_name(const SurfacePatch& p, const Regions& regions) {
  return region_of(regions, p.inside).name() + "-" +
         (p.side >= 0 ? std::string(kSides[p.side]) : region_of(regions, p.other).name());
}

// Pairs of patches on opposite sides, by their numbers, with the nodes of the first and their images.
struct Link {
  std::size_t from, to;
  std::map<std::int32_t, std::int32_t> nodes;
};

std::vector<Link> periodic_links(const SurfaceNet& net) {
  std::vector<std::map<std::int32_t, std::int32_t>> image(3);
  for (std::size_t a = 0; a < 3; ++a)
    for (const auto& [node, other] : net.periodic[a]) image[a].emplace(node, other);
  std::map<std::array<std::int32_t, 3>, std::size_t> at_side;  // patch by piece, its image and side
  for (std::size_t p = 0; p < net.patches.size(); ++p)
    if (const SurfacePatch& q = net.patches[p]; q.side >= 0)
      at_side[{q.inside_piece, q.other_piece, q.side}] = p;
  std::vector<Link> links;
  std::map<std::int32_t, std::size_t> link_of;
  for (std::size_t p = 0; p < net.patches.size(); ++p) {
    const SurfacePatch& patch = net.patches[p];
    if (patch.side < 0 || patch.side % 2 == 0 || net.periodic[patch.side / 2].empty()) continue;
    link_of[p] = links.size();
    links.push_back({p, at_side.at({patch.other_piece, patch.inside_piece, patch.side - 1}), {}});
  }
  for (std::size_t t = 0; t < net.corners.size(); ++t) {
    const auto it = link_of.find(net.patch_of[t]);
    if (it == link_of.end()) continue;
    const std::size_t axis = net.patches[net.patch_of[t]].side / 2;
    for (const std::int32_t n : net.corners[t]) links[it->second].nodes.emplace(n, image[axis].at(n));
  }
  return links;
}

}  // namespace

void write_msh(const std::filesystem::path& path, const SurfaceNet& net, const Regions& regions,
               const Work& work) {
  const auto links = periodic_links(net);
  std::map<std::array<std::int32_t, 3>, std::int32_t> physical;  // tag by regions and side
  std::vector<std::string> names;
  std::vector<std::int32_t> tags;  // of the patches
  for (const SurfacePatch& p : net.patches) {
    const auto [it, added] = physical.emplace(std::array<std::int32_t, 3>{p.inside, p.other, p.side},
                                              static_cast<std::int32_t>(names.size()) + 1);
    if (added) names.push_back(patch_name(p, regions));
    tags.push_back(it->second);
  }
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    out << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n" << names.size() << '\n';
    for (std::size_t k = 0; k < names.size(); ++k) out << fmt::format("2 {} \"{}\"\n", k + 1, names[k]);
    out << "$EndPhysicalNames\n$Nodes\n" << net.nodes.size() << '\n';
    for (std::size_t n = 0; n < net.nodes.size(); ++n) {
      if (n % 65536 == 0) {
        work.check();
        work.progress(0.4 * double(n) / double(net.nodes.size()));
      }
      const Vec3& p = net.nodes[n];
      out << fmt::format("{} {} {} {}\n", n + 1, p.x(), p.y(), p.z());
    }
    out << "$EndNodes\n$Elements\n" << net.corners.size() << '\n';
    for (std::size_t t = 0; t < net.corners.size(); ++t) {
      if (t % 65536 == 0) {
        work.check();
        work.progress(0.4 + 0.5 * double(t) / double(net.corners.size()));
      }
      const auto& c = net.corners[t];
      const std::int32_t patch = net.patch_of[t];
      out << fmt::format("{} {} {} {} {} {} {} {}\n", t + 1, kTriangle, kTags, tags[patch], patch + 1,
                         c[0] + 1, c[1] + 1, c[2] + 1);
    }
    out << "$EndElements\n";
    if (links.empty()) return;
    out << "$Periodic\n" << links.size() << '\n';
    for (const Link& l : links) {
      out << fmt::format("2 {} {}\n{}\n", l.from + 1, l.to + 1, l.nodes.size());
      for (const auto& [node, image] : l.nodes) out << fmt::format("{} {}\n", node + 1, image + 1);
    }
    out << "$EndPeriodic\n";
  });
}

void write_geo(const std::filesystem::path& path, const std::string& msh, const SurfaceNet& net,
               const Regions& regions) {
  if (msh.find_first_of("\"\\") != std::string::npos)
    throw Error("bad-names",
                "the file name contains a quotation mark or backslash, which a script of Gmsh cannot name",
                "rename it")
        .parameter("path");
  std::vector<std::string> loops(net.region_of_piece.size()), volumes(regions.all.size());
  const auto add = [](std::string& list, std::int64_t number) {
    list += (list.empty() ? "" : ", ") + std::to_string(number);
  };
  for (std::size_t p = 0; p < net.patches.size(); ++p) {
    const SurfacePatch& patch = net.patches[p];
    const auto tag = static_cast<std::int64_t>(p) + 1;
    add(loops[patch.inside_piece], tag);
    if (patch.side < 0) add(loops[patch.other_piece], -tag);
  }
  std::string text =
      fmt::format("// Surfaces of Terrazzo. Tetrahedra: gmsh -3 -o tetrahedra.msh {}\nMerge \"{}\";\n",
                  std::filesystem::path(msh).stem().string() + ".geo", msh);  // `path` is a temporary name
  for (std::size_t k = 0; k < loops.size(); ++k) {
    text += fmt::format("Surface Loop({0}) = {{{1}}};\nVolume({0}) = {{{0}}};\n", k + 1, loops[k]);
    add(volumes[net.region_of_piece[k]], static_cast<std::int64_t>(k) + 1);
  }
  for (std::size_t r = 0; r < volumes.size(); ++r)
    if (!volumes[r].empty())
      text += fmt::format("Physical Volume(\"{}\") = {{{}}};\n", regions.all[r].name(), volumes[r]);
  write_bytes(path, text);
}

void write_surface_stl(const std::filesystem::path& path, const SurfaceNet& net, const Regions& regions,
                       const Work& work) {
  const auto solid = [&](std::int32_t number) {
    if (number <= 0) return false;  // the binder, or outside
    return region_of(regions, number).is != Region::Is::Void;
  };
  std::vector<std::int8_t> way;  // of each patch: 1 and −1 are at the surface, −1 with the normal reversed
  for (const SurfacePatch& p : net.patches) way.push_back(solid(p.inside) - solid(p.other));
  std::uint64_t count = 0;
  for (const std::int32_t p : net.patch_of) count += way[p] != 0;
  if (count == 0) throw Error("no-particles", "the volume has no particle with a surface");
  if (count > 0xffffffffu)
    throw Error("too-large", fmt::format("the surface has {} triangles; a .stl file holds 4294967295", count),
                "use fewer voxels");
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    const char header[80] = "Terrazzo, mm";
    const std::uint32_t triangles = count;
    out.write(header, sizeof header).write(reinterpret_cast<const char*>(&triangles), 4);
    for (std::size_t t = 0; t < net.corners.size(); ++t) {
      if (t % 65536 == 0) {
        work.check();
        work.progress(double(t) / double(net.corners.size()));
      }
      const int w = way[net.patch_of[t]];
      if (w == 0) continue;
      std::array<std::int32_t, 3> c = net.corners[t];
      if (w < 0) std::swap(c[1], c[2]);
      std::array<Vec3, 4> v;  // normal, corners
      for (std::size_t k = 0; k < 3; ++k) v[k + 1] = net.nodes[c[k]];
      const Vec3 normal = (v[2] - v[1]).cross(v[3] - v[1]);
      v[0] = normal.norm() > 0 ? Vec3(normal.normalized()) : Vec3(0, 0, 0);
      for (const Vec3& p : v) {
        const Vec3f f = p.cast<float>();
        out.write(reinterpret_cast<const char*>(f.data()), 12);
      }
      out.write("\0\0", 2);
    }
  });
}

}  // namespace terrazzo::exporting
