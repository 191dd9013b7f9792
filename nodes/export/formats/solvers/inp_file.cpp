#include "nodes/export/formats/solvers/inp_file.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "nodes/common/io/checked_file.h"
#include "runtime/memory.h"

namespace terrazzo::exporting {
namespace {

constexpr double kLargestLabel = 999'999'999;  // Abaqus: nine digits

// Collects text and passes it on in large pieces.
class InpText {
 public:
  explicit InpText(std::ostream& out) : out_(out) {}
  template <class... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
    if (text_.size() > (1 << 20)) flush();
  }
  void flush() {
    out_.write(text_.data(), text_.size());
    text_.clear();
  }

 private:
  std::ostream& out_;
  fmt::memory_buffer text_;
};

struct InpNodes {
  explicit InpNodes(const VoxelBox& box) : n(box.size + Vec3i::Ones()) {}
  std::int64_t label(int i, int j, int k) const {
    return 1 + i + n.x() * (j + static_cast<std::int64_t>(n.y()) * k);
  }
  std::int64_t label(const Vec3i& at) const { return label(at.x(), at.y(), at.z()); }
  Vec3i n;
};

// A set of the nodes lo ≤ (i, j, k) ≤ hi, twelve labels per line. Writes nothing if there is none.
void add_node_set(InpText& text, const InpNodes& nodes, const std::string& name, const Vec3i& lo,
                  const Vec3i& hi) {
  if ((hi - lo).minCoeff() < 0) return;
  text.add("*NSET, NSET={}\n", name);
  int on_line = 0;
  for (int k = lo.z(); k <= hi.z(); ++k)
    for (int j = lo.y(); j <= hi.y(); ++j)
      for (int i = lo.x(); i <= hi.x(); ++i) {
        text.add("{}{}", on_line ? ", " : "", nodes.label(i, j, k));
        if (++on_line == 12) {
          text.add("\n");
          on_line = 0;
        }
      }
  if (on_line) text.add("\n");
}

constexpr std::array<char, 3> kAxes = {'X', 'Y', 'Z'};

void add_node_sets(InpText& text, const InpNodes& nodes, const Work& work) {
  const Vec3i last = nodes.n - Vec3i::Ones();
  const auto add = [&](const std::string& name, const Vec3i& lo, const Vec3i& hi) {
    work.check();
    add_node_set(text, nodes, name, lo, hi);
  };
  for (int a = 0; a < 3; ++a)
    for (int side = 0; side < 2; ++side) {
      Vec3i lo = Vec3i::Zero(), hi = last;
      lo[a] = hi[a] = side * last[a];
      const std::string name = fmt::format("{}{}", kAxes[a], side);
      add("SIDE_" + name, lo, hi);
      for (int b = 0; b < 3; ++b)
        if (b != a) {
          ++lo[b];
          --hi[b];
        }
      add("FACE_" + name, lo, hi);
    }
  for (int a = 0; a < 3; ++a)
    for (int sides = 0; sides < 4; ++sides) {
      Vec3i lo = Vec3i::Zero(), hi = last;
      ++lo[a];
      --hi[a];
      std::string name = "EDGE";
      for (int b = 0, bit = 0; b < 3; ++b) {
        if (b == a) continue;
        const int side = sides >> bit++ & 1;
        lo[b] = hi[b] = side * last[b];
        name += fmt::format("_{}{}", kAxes[b], side);
      }
      add(name, lo, hi);
    }
  for (int c = 0; c < 8; ++c) {
    const Vec3i side(c & 1, c >> 1 & 1, c >> 2 & 1);
    const Vec3i at = side.cwiseProduct(last);
    add(fmt::format("CORNER_{}{}{}", side.x(), side.y(), side.z()), at, at);
  }
}

// Voxels of each region, in order: those of region r are at start[r] … start[r + 1].
struct InpElements {
  std::vector<std::uint32_t> voxel;
  std::vector<std::size_t> start;
};
InpElements sort_voxels(const VoxelSource& id, const VoxelBox& box, const Regions& regions,
                        const Work& work) {
  InpElements out;
  out.start.push_back(0);
  for (const Region& r : regions.all) out.start.push_back(out.start.back() + r.voxels);
  out.voxel.resize(box.count());
  std::vector<std::size_t> next(out.start.begin(), out.start.end() - 1);
  std::vector<std::int32_t> plane(box.plane());
  for (int z = 0; z < box.size.z(); ++z) {
    work.check();
    id.read(z, z + 1, plane.data());
    for (std::size_t i = 0; i < plane.size(); ++i)
      out.voxel[next[regions.number(plane[i])]++] = box.plane() * z + i;
  }
  return out;
}

// A set of other element sets. One name per line, since some readers see only the first.
void add_set_of_sets(InpText& text, const std::string& name, const Regions& regions, auto&& belongs) {
  bool any = false;
  for (const Region& r : regions.all)
    if (r.voxels > 0 && r.name() != name && belongs(r)) {
      if (!any) text.add("*ELSET, ELSET={}\n", name);
      any = true;
      text.add("{}\n", r.name());
    }
}

void add_element_sets(InpText& text, const Regions& regions) {
  std::int32_t last_phase = 0;
  bool by_particle = false;
  for (const Region& r : regions.all) {
    last_phase = std::max(last_phase, r.phase);
    by_particle = by_particle || r.is == Region::Is::Particle;
  }
  using Is = Region::Is;
  if (by_particle)
    for (std::int32_t phase = 1; phase <= last_phase; ++phase)
      add_set_of_sets(text, fmt::format("PHASE_{}", phase - 1), regions,
                      [&](const Region& r) { return r.is == Is::Particle && r.phase == phase; });
  add_set_of_sets(text, "VOIDS", regions, [](const Region& r) { return r.is == Is::Void; });
  add_set_of_sets(text, "PARTICLES", regions,
                  [](const Region& r) { return r.is == Is::Particle || r.is == Is::Phase; });
  add_set_of_sets(text, "ALL_ELEMENTS", regions, [](const Region&) { return true; });
}

// JSON needs no line breaks; one would end the comment.
void add_comment(InpText& text, std::string provenance) {
  constexpr std::size_t kWidth = 100;
  std::erase_if(provenance, [](char c) { return c == '\n' || c == '\r'; });
  for (std::size_t at = 0; at < provenance.size(); at += kWidth)
    text.add("**provenance {}\n", provenance.substr(at, kWidth));
}

}  // namespace

void check_inp(const VoxelBox& box) {
  const double nodes = (box.size.cast<double>() + Vec3::Ones()).prod();
  if (nodes > kLargestLabel)
    throw Error(
        "too-large",
        fmt::format("{} × {} × {} voxels have {:.0f} nodes; the limit of Abaqus is {:.0f} (nine digits)",
                    box.size.x(), box.size.y(), box.size.z(), nodes, kLargestLabel),
        "voxelize with a lower resolution, or write .vti");
}

void write_inp(const std::filesystem::path& path, const VoxelSource& id, const VoxelBox& box,
               const Regions& regions, std::uint64_t memory, const std::string& provenance,
               const Work& work) {
  check_inp(box);
  require_memory(4.0 * double(box.count()), memory, "the list of elements");
  const InpElements elements = sort_voxels(id, box, regions, work.part(0, 0.1));
  const InpNodes nodes(box);
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    InpText text(out);
    text.add("** Terrazzo: voxel mesh of {} x {} x {} elements. Lengths in mm; use MPa and N.\n",
             box.size.x(), box.size.y(), box.size.z());
    text.add(
        "** Mesh only. Read it with *INCLUDE and add materials, sections, boundary conditions and steps.\n");
    add_comment(text, provenance);
    text.add("*NODE, NSET=ALL_NODES\n");
    const Work node_work = work.part(0.1, 0.4);
    for (int k = 0; k < nodes.n.z(); ++k) {
      node_work.check();
      node_work.progress(double(k) / nodes.n.z());
      for (int j = 0; j < nodes.n.y(); ++j)
        for (int i = 0; i < nodes.n.x(); ++i) {
          const Vec3 p = box.corner + Vec3(i, j, k).cwiseProduct(box.spacing);
          // CalculiX reads the first 20 characters of a number.
          text.add("{}, {:.10g}, {:.10g}, {:.10g}\n", nodes.label(i, j, k), p.x(), p.y(), p.z());
        }
    }
    const Work element_work = work.part(0.4, 0.9);
    const std::size_t nx = box.size.x();
    for (std::size_t r = 0; r < regions.all.size(); ++r) {
      if (regions.all[r].voxels == 0) continue;
      text.add("*ELEMENT, TYPE=C3D8, ELSET={}\n", regions.all[r].name());
      for (std::size_t e = elements.start[r]; e < elements.start[r + 1]; ++e) {
        if (e % 65536 == 0) {
          element_work.check();
          element_work.progress(double(e) / double(box.count()));
        }
        const std::size_t v = elements.voxel[e];
        const std::int64_t step = nodes.n.x(), layer = step * nodes.n.y();
        const std::int64_t a = nodes.label(static_cast<int>(v % nx), static_cast<int>(v / nx % box.size.y()),
                                           static_cast<int>(v / box.plane()));
        text.add("{}, {}, {}, {}, {}, {}, {}, {}, {}\n", v + 1, a, a + 1, a + step + 1, a + step, a + layer,
                 a + layer + 1, a + layer + step + 1, a + layer + step);
      }
    }
    add_element_sets(text, regions);
    add_node_sets(text, nodes, work.part(0.9, 1));
    text.flush();
  });
}

void write_periodic_inp(const std::filesystem::path& path, const VoxelBox& box, const Work& work) {
  const InpNodes nodes(box);
  const Vec3i last = nodes.n - Vec3i::Ones();
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    InpText text(out);
    text.add(
        "** Periodic displacements. Read it with *INCLUDE after the mesh. Fix CORNER_000, and prescribe or\n"
        "** free CORNER_100, CORNER_010 and CORNER_001: they carry the mean deformation.\n"
        "*EQUATION\n");
    for (int k = 0; k <= last.z(); ++k) {
      work.check();
      work.progress(double(k) / nodes.n.z());
      for (int j = 0; j <= last.y(); ++j)
        for (int i = 0; i <= last.x(); ++i) {
          if (i < last.x() && j < last.y() && k < last.z()) {
            i = last.x() - 1;  // nothing until the side X1
            continue;
          }
          const Vec3i at(i, j, k);
          Vec3i partner = at;
          std::array<std::pair<std::int64_t, int>, 6> terms;  // node and factor
          std::size_t count = 0;
          const auto add = [&](std::int64_t node, int factor) {
            for (std::size_t t = 0; t < count; ++t)
              if (terms[t].first == node) {
                terms[t].second += factor;
                return;
              }
            terms[count++] = {node, factor};
          };
          add(nodes.label(at), 1);
          for (int a = 0; a < 3; ++a)
            if (at[a] == last[a]) partner[a] = 0;
          add(nodes.label(partner), -1);
          for (int a = 0; a < 3; ++a)
            if (at[a] == last[a]) {
              Vec3i corner = Vec3i::Zero();
              corner[a] = last[a];
              add(nodes.label(corner), -1);
              add(nodes.label(0, 0, 0), 1);
            }
          if (terms[0].second == 0) continue;  // a corner that carries the deformation
          std::size_t used = 0;
          for (std::size_t t = 0; t < count; ++t)
            if (terms[t].second != 0) terms[used++] = terms[t];
          for (int dof = 1; dof <= 3; ++dof) {
            text.add("{}\n", used);
            for (std::size_t t = 0; t < used; ++t)  // at most four terms per line
              text.add("{}{}, {}, {}.",
                       t == 0  ? ""
                       : t % 4 ? ", "
                               : "\n",
                       terms[t].first, dof, terms[t].second);
            text.add("\n");
          }
        }
    }
    text.flush();
  });
}

}  // namespace terrazzo::exporting
