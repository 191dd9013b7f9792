#include "nodes/packing/measure3d/pieces.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace terrazzo::measure3d {
namespace {

// Voxels [begin, end) of a row that have one label.
struct Run {
  std::int32_t label;
  int begin, end;
};

// The runs of all rows, joined where they touch by faces of voxels.
class Runs {
 public:
  Runs(const Raster& raster, const Work& work) : raster_(raster), size_(raster.box.size) {
    list(work);
    parent_.resize(runs.size());
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
    join(work);
  }

  std::vector<Run> runs;
  std::vector<std::size_t> row_begin;  // first run of each row, + 1

  std::size_t root(std::size_t k) {
    while (parent_[k] != k) k = parent_[k] = parent_[parent_[k]];
    return k;
  }

 private:
  const Raster& raster_;
  Vec3i size_;
  std::vector<std::size_t> parent_;

  std::size_t row(int y, int z) const { return static_cast<std::size_t>(z) * size_.y() + y; }

  void list(const Work& work) {
    row_begin.push_back(0);
    for (int z = 0; z < size_.z(); ++z) {
      work.check();
      for (int y = 0; y < size_.y(); ++y) {
        const std::int32_t* ids = &raster_.ids[raster_.index(0, y, z)];
        for (int x = 0; x < size_.x();) {
          const int begin = x;
          while (x < size_.x() && ids[x] == ids[begin]) ++x;
          if (ids[begin] >= 0) runs.push_back({ids[begin], begin, x});
        }
        row_begin.push_back(runs.size());
      }
    }
  }

  void join(const Work& work) {
    const bool wraps = raster_.box.periodic;
    for (int z = 0; z < size_.z(); ++z) {
      work.check();
      for (int y = 0; y < size_.y(); ++y) {
        if (wraps) join_ends(row(y, z));
        if (y + 1 < size_.y() || wraps) join_rows(row(y, z), row((y + 1) % size_.y(), z));
        if (z + 1 < size_.z() || wraps) join_rows(row(y, z), row(y, (z + 1) % size_.z()));
      }
    }
  }

  void join_ends(std::size_t r) {
    if (row_begin[r] == row_begin[r + 1]) return;
    const std::size_t a = row_begin[r], b = row_begin[r + 1] - 1;
    if (runs[a].begin == 0 && runs[b].end == size_.x() && runs[a].label == runs[b].label) unite(a, b);
  }

  void join_rows(std::size_t r, std::size_t s) {
    std::size_t a = row_begin[r], b = row_begin[s];
    while (a < row_begin[r + 1] && b < row_begin[s + 1]) {
      const bool overlap = runs[a].begin < runs[b].end && runs[b].begin < runs[a].end;
      if (overlap && runs[a].label == runs[b].label) unite(a, b);
      ++(runs[a].end < runs[b].end ? a : b);
    }
  }

  // The root is the first run, so that pieces have an order.
  void unite(std::size_t a, std::size_t b) {
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }
};

struct Piece {
  std::int32_t label = 0;
  double voxels = 0;
  bool spans = false;
};

struct Pieces {
  std::vector<std::int32_t> of_run;
  std::vector<Piece> all;  // by their first run
};

Pieces pieces_of(Runs& runs) {
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
void find_spanning(Pieces& pieces, const Runs& runs, const Vec3i& n, const Work& work) {
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
  Runs runs(raster, work);
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
