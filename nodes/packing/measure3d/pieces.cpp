#include "nodes/packing/measure3d/pieces.h"

#include <algorithm>
#include <map>

#include "nodes/common/geometry/grid/runs.h"

namespace terrazzo::measure3d {
namespace {

struct Piece {
  std::int32_t label = 0;
  double voxels = 0;
  bool spans = false;
};

struct Pieces {
  std::vector<std::int32_t> of_run;
  std::vector<Piece> all;  // by their first run
};

Pieces pieces_of(VoxelRuns& runs) {
  Pieces out;
  for (std::size_t k = 0; k < runs.runs.size(); ++k) {
    const std::size_t root = runs.root(k);
    if (root == k) {
      out.of_run.push_back(out.all.size());
      out.all.push_back({runs.runs[k].label, 0, false});
    } else {
      out.of_run.push_back(out.of_run[root]);
    }
    out.all[out.of_run[k]].voxels += runs.runs[k].end - runs.runs[k].begin;
  }
  return out;
}

// Finds which pieces have voxels in all planes across some axis.
void find_spanning(Pieces& pieces, const VoxelRuns& runs, const Vec3i& n, const Work& work) {
  std::vector<std::vector<bool>> planes(pieces.all.size());  // along x, then y, then z
  const double fewest = n.minCoeff();
  for (std::size_t row = 0; row + 1 < runs.row_begin.size(); ++row) {
    if (row % 4096 == 0) work.check();
    const auto y = row % n.y(), z = row / n.y();
    for (std::size_t k = runs.row_begin[row]; k < runs.row_begin[row + 1]; ++k) {
      if (pieces.all[pieces.of_run[k]].voxels < fewest) continue;
      std::vector<bool>& p = planes[pieces.of_run[k]];
      if (p.empty()) p.resize(n.sum());
      std::fill(p.begin() + runs.runs[k].begin, p.begin() + runs.runs[k].end, true);
      p[n.x() + y] = p[n.x() + n.y() + z] = true;
    }
  }
  for (std::size_t k = 0; k < planes.size(); ++k) {
    if (planes[k].empty()) continue;
    const auto x = planes[k].begin(), y = x + n.x(), z = y + n.y();
    const auto full = [](auto from, auto to) { return std::find(from, to, false) == to; };
    pieces.all[k].spans = full(x, y) || full(y, z) || full(z, planes[k].end());
  }
}

std::vector<std::int32_t> labels_of_phases(const std::vector<Piece>& pieces) {
  struct Label {
    double voxels = 0, largest = 0;
    bool spans = false;
  };
  std::map<std::int32_t, Label> labels;
  for (const Piece& piece : pieces) {
    Label& label = labels[piece.label];
    label.voxels += piece.voxels;
    label.largest = std::max(label.largest, piece.voxels);
    label.spans |= piece.spans;
  }
  std::vector<std::int32_t> out;
  for (const auto& [id, label] : labels)
    if (label.spans || 2 * label.largest < label.voxels) out.push_back(id);
  return out;
}

}  // namespace

Phases split_phases(Raster& raster, const Work& work) {
  VoxelRuns runs(raster.ids.data(), raster.box, work);
  Pieces pieces = pieces_of(runs);
  if (raster.box.periodic) find_spanning(pieces, runs, raster.box.size, work);
  Phases out;
  out.labels = labels_of_phases(pieces.all);
  for (const Piece& piece : pieces.all) out.first = std::max(out.first, piece.label + 1);
  if (out.labels.empty()) return out;
  std::vector<std::int32_t> renamed(pieces.all.size(), -1);
  for (std::size_t k = 0; k < renamed.size(); ++k) {
    const Piece& piece = pieces.all[k];
    if (!std::binary_search(out.labels.begin(), out.labels.end(), piece.label)) continue;
    renamed[k] = out.first + static_cast<std::int32_t>(out.label_of.size());
    out.label_of.push_back(piece.label);
    out.spans.push_back(piece.spans);
  }
  const std::size_t nx = raster.box.size.x();
  for (std::size_t row = 0; row + 1 < runs.row_begin.size(); ++row)
    for (std::size_t k = runs.row_begin[row]; k < runs.row_begin[row + 1]; ++k)
      if (const std::int32_t to = renamed[pieces.of_run[k]]; to >= 0) {
        const auto at = raster.ids.begin() + (row * nx);
        std::fill(at + runs.runs[k].begin, at + runs.runs[k].end, to);
      }
  return out;
}

}  // namespace terrazzo::measure3d
