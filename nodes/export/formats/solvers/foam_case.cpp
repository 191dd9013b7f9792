#include "nodes/export/formats/solvers/foam_case.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "nodes/common/io/checked_file.h"
#include "nodes/export/formats/units.h"
#include "runtime/memory.h"

namespace terrazzo::exporting {
namespace {

constexpr std::int32_t kBinder = 0;

// The other region of each patch of the binder's surface, or −1; its numbers in the order of the regions.
std::map<std::int32_t, std::vector<std::int32_t>> patches_of_binder(const SurfaceNet& net) {
  std::map<std::int32_t, std::vector<std::int32_t>> out;
  for (std::size_t p = 0; p < net.patches.size(); ++p) {
    const SurfacePatch& patch = net.patches[p];
    if (patch.side < 0 && patch.inside == kBinder) out[patch.other].push_back(p);
    if (patch.side < 0 && patch.other == kBinder) out[patch.inside].push_back(p);
  }
  return out;
}

std::string header(const std::string& object) {
  return fmt::format(
      "FoamFile\n{{\n    version 2.0;\n    format ascii;\n    class dictionary;\n    object {};\n}}\n",
      object);
}

std::string point_text(const Vec3& mm) {
  const Vec3 m = mm * kMetersPerMm;
  return fmt::format("({:.12g} {:.12g} {:.12g})", m.x(), m.y(), m.z());
}

std::string block_mesh(const Vec3& low, const Vec3& high, const Vec3i& cells) {
  std::string text = header("blockMeshDict") + "scale 1;\nvertices\n(\n";
  for (const auto& [x, y, z] :
       {std::tuple{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}})
    text += "    " +
            point_text(Vec3(x ? high.x() : low.x(), y ? high.y() : low.y(), z ? high.z() : low.z())) + "\n";
  text += fmt::format(
      ");\nblocks\n(\n    hex (0 1 2 3 4 5 6 7) ({} {} {}) simpleGrading (1 1 1)\n);\nedges ();\n", cells.x(),
      cells.y(), cells.z());
  text += "boundary\n(\n";
  for (const auto& [name, corners] : {std::pair{"X0", "0 4 7 3"},
                                      {"X1", "1 2 6 5"},
                                      {"Y0", "0 1 5 4"},
                                      {"Y1", "3 7 6 2"},
                                      {"Z0", "0 3 2 1"},
                                      {"Z1", "4 5 6 7"}})
    text += fmt::format("    {} {{ type patch; faces (({})); }}\n", name, corners);
  return text + ");\n";
}

std::string snappy(const std::string& stl, const SurfaceNet& net, const Regions& regions,
                   const Vec3& inside) {
  std::string text =
      header("snappyHexMeshDict") +
      "castellatedMesh true;\nsnap true;\naddLayers false;\ngeometry\n{\n    \"" + stl +
      "\"\n    {\n        type triSurfaceMesh;\n        name particles;\n        regions\n        {\n";
  for (const auto& [other, patches] : patches_of_binder(net))
    text += fmt::format("            {0} {{ name {0}; }}\n", regions.all[other].name());
  return text +
         "        }\n    }\n}\ncastellatedMeshControls\n{\n    maxLocalCells 100000000;\n"
         "    maxGlobalCells 100000000;\n    minRefinementCells 0;\n    nCellsBetweenLevels 1;\n"
         "    resolveFeatureAngle 180;\n    features ();\n    refinementSurfaces\n    {\n"
         "        particles { level (1 1); }\n    }\n    refinementRegions {}\n    locationInMesh " +
         point_text(inside) +
         ";\n    allowFreeStandingZoneFaces true;\n}\n"
         "snapControls\n{\n    nSmoothPatch 3;\n    tolerance 2;\n    nSolveIter 50;\n    nRelaxIter 5;\n}\n"
         "addLayersControls\n{\n    relativeSizes true;\n    layers {}\n    expansionRatio 1;\n"
         "    finalLayerThickness 0.3;\n    minThickness 0.1;\n    nGrow 0;\n    featureAngle 60;\n"
         "    nRelaxIter 3;\n    nSmoothSurfaceNormals 1;\n    nSmoothNormals 3;\n    nSmoothThickness 10;\n"
         "    maxFaceThicknessRatio 0.5;\n    maxThicknessToMedialRatio 0.3;\n    minMedianAxisAngle 90;\n"
         "    nBufferCellsNoExtrude 0;\n    nLayerIter 50;\n}\n"
         "meshQualityControls\n{\n    maxNonOrtho 65;\n    maxBoundarySkewness 20;\n    maxInternalSkewness "
         "4;\n"
         "    maxConcave 80;\n    minVol 1e-30;\n    minTetQuality -1;\n    minArea -1;\n    minTwist 0.02;\n"
         "    minDeterminant 0.001;\n    minFaceWeight 0.05;\n    minVolRatio 0.01;\n    minTriangleTwist "
         "-1;\n"
         "    nSmoothScale 4;\n    errorReduction 0.75;\n}\nmergeTolerance 1e-6;\n";
}

}  // namespace

void write_foam_surface(const std::filesystem::path& path, const SurfaceNet& net, const Regions& regions,
                        const Work& work) {
  const auto patches = patches_of_binder(net);
  if (patches.empty())
    throw Error("no-particles", "the binder has no surface", "connect a volume with particles");
  std::vector<std::vector<std::int32_t>> triangles(net.patches.size());
  for (std::size_t t = 0; t < net.corners.size(); ++t) triangles[net.patch_of[t]].push_back(t);
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    double done = 0;
    for (const auto& [other, members] : patches) {
      out << "solid " << regions.all[other].name() << '\n';
      for (const std::int32_t p : members)
        for (const std::int32_t t : triangles[p]) {
          if (std::size_t(done++) % 65536 == 0) {
            work.check();
            work.progress(done / double(net.corners.size()));
          }
          std::array<std::int32_t, 3> c = net.corners[t];
          if (net.patches[p].inside != kBinder) std::swap(c[1], c[2]);
          const Vec3 a = net.nodes[c[0]] * kMetersPerMm, b = net.nodes[c[1]] * kMetersPerMm,
                     d = net.nodes[c[2]] * kMetersPerMm;
          const Vec3 normal = (b - a).cross(d - a).stableNormalized();
          out << fmt::format("facet normal {:.6g} {:.6g} {:.6g}\nouter loop\n", normal.x(), normal.y(),
                             normal.z());
          for (const Vec3& v : {a, b, d})
            out << fmt::format("vertex {:.12g} {:.12g} {:.12g}\n", v.x(), v.y(), v.z());
          out << "endloop\nendfacet\n";
        }
      out << "endsolid " << regions.all[other].name() << '\n';
    }
  });
}

Vec3 inside_of_binder(const VoxelSource& id, const VoxelBox& box, const Regions& regions,
                      std::uint64_t memory, const Work& work) {
  require_memory(double(box.count()) * 4, memory, "the distances in the binder");
  const Vec3i n = box.size;
  // City-block distance in voxels from what is no binder and from the sides.
  std::vector<std::int32_t> distance(box.count());
  for (int z = 0; z < n.z(); ++z) {
    work.check();
    id.read(z, z + 1, distance.data() + box.plane() * z);
  }
  for (std::int32_t& d : distance) d = regions.number(d) == kBinder ? 1 << 30 : 0;
  const std::array<std::ptrdiff_t, 3> step = {1, n.x(), std::ptrdiff_t(box.plane())};
  const auto sweep = [&](int way) {
    const std::ptrdiff_t count = distance.size();
    for (std::ptrdiff_t s = 0; s < count; ++s) {
      const std::ptrdiff_t i = way > 0 ? s : count - 1 - s;
      if (s % 65536 == 0) work.check();
      const Vec3i at(i % n.x(), i / n.x() % n.y(), i / step[2]);
      for (int a = 0; a < 3; ++a) {
        const int next = at[a] - way;
        const std::int32_t there = next < 0 || next >= n[a] ? 0 : distance[i - way * step[a]];
        distance[i] = std::min(distance[i], there + 1);
      }
    }
  };
  sweep(1);
  sweep(-1);
  const auto best = std::max_element(distance.begin(), distance.end());
  if (best == distance.end() || *best < 1)
    throw Error("no-binder", "the volume has no binder to mesh for a fluid", "use a volume with pores");
  const std::ptrdiff_t i = best - distance.begin();
  const Vec3 at(i % n.x(), i / n.x() % n.y(), i / step[2]);
  // Cells of the background mesh meet at centers of voxels: the point must be on none of their faces.
  return box.corner + (at + Vec3(0.63, 0.67, 0.71)).cwiseProduct(box.spacing);
}

std::map<std::string, std::string> foam_dictionaries(const std::string& stl, const SurfaceNet& net,
                                                     const VoxelBox& box, const Regions& regions,
                                                     const Vec3& inside) {
  Vec3 low = net.nodes[0], high = low;
  for (const Vec3& p : net.nodes) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return {{"system/blockMeshDict", block_mesh(low, high, box.size)},
          {"system/snappyHexMeshDict", snappy(stl, net, regions, inside)},
          {"system/controlDict",
           header("controlDict") +
               "application simpleFoam;\nstartFrom startTime;\nstartTime 0;\nstopAt endTime;\n"
               "endTime 1000;\ndeltaT 1;\nwriteControl timeStep;\nwriteInterval 1000;\n"
               "writeFormat binary;\nwritePrecision 12;\n"},
          {"system/fvSchemes", header("fvSchemes") +
                                   "ddtSchemes {}\ngradSchemes {}\ndivSchemes {}\nlaplacianSchemes {}\n"
                                   "interpolationSchemes {}\nsnGradSchemes {}\n"},
          {"system/fvSolution", header("fvSolution") + "solvers {}\n"}};
}

}  // namespace terrazzo::exporting
