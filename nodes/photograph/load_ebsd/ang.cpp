// EDAX/TSL .ang: a header of lines that begin with #, then a line per point: the Euler angles, x and y, image
// quality, confidence index, phase, and more.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/common/io/cell_rows.h"
#include "nodes/common/io/reading.h"
#include "nodes/photograph/load_ebsd/ang_header.h"
#include "nodes/photograph/load_ebsd/grid.h"

namespace terrazzo::load_ebsd {
namespace {

class PointReader {
 public:
  PointReader(const AngHeader& header, const Lines& lines) : header_(header), lines_(lines) {
    int place = 0;
    for (const auto& entry : header.phases) position_[entry.first] = place++;
    if (header.phases.size() == 1) position_[0] = 0;  // maps of one phase number it 0 or 1
  }

  void read(const std::vector<std::string_view>& cells, PointList& out) {
    if (expected_ == 0) find_columns(cells.size());
    if (cells.size() < expected_)
      lines_.malformed(fmt::format("{} numbers; at least {} are expected", cells.size(), expected_));
    double v[AngHeader::Columns] = {};
    for (std::size_t i = 0; i < AngHeader::Columns; ++i) {
      if (header_.at[i] == std::string_view::npos) continue;
      const std::string_view cell = cells[header_.at[i]];
      const auto n = number_in(cell);
      if (!n) lines_.malformed(fmt::format("'{}' is not a number", printable(cell)));
      v[i] = *n;
    }
    out.add(point_of(v), cells[header_.at[AngHeader::X]], cells[header_.at[AngHeader::Y]], header_.length,
            lines_);
  }

 private:
  // By the first row: files before version 3 have no phases, and those before version 2 no confidence.
  void find_columns(std::size_t count) {
    constexpr std::size_t kFewest = AngHeader::Quality + 1;
    if (!header_.names_columns && count < kFewest)
      lines_.malformed(fmt::format("{} numbers; at least {} are expected", count, kFewest));
    for (std::size_t& at : header_.at) {
      if (!header_.names_columns && at >= count) at = std::string_view::npos;
      if (at != std::string_view::npos) expected_ = std::max(expected_, at + 1);
    }
    if (header_.at[AngHeader::PhaseNumber] == std::string_view::npos && header_.phases.size() > 1)
      lines_.malformed(
          fmt::format("the points have no phase, but the header names {}", header_.phases.size()));
  }

  MapPoint point_of(const double (&v)[AngHeader::Columns]) const {
    for (const int i : {AngHeader::Phi1, AngHeader::Phi, AngHeader::Phi2})
      if (std::abs(v[i] * header_.angle) > 13)  // 4π marks points that were not indexed
        lines_.malformed(header_.angle == 1
                             ? fmt::format("the Euler angle {} must be in radians, from -13 to 13", v[i])
                             : fmt::format("the Euler angle {} must be in degrees, from -740 to 740", v[i]));
    MapPoint p;
    p.quality = static_cast<float>(v[AngHeader::Quality]);
    p.confidence = static_cast<float>(v[AngHeader::Confidence]);
    const double number = v[AngHeader::PhaseNumber];
    const auto known = number == std::floor(number) && std::abs(number) < 1e6
                           ? position_.find(static_cast<int>(number))
                           : position_.end();
    if (known == position_.end() && number != 0 && number != -1)
      lines_.malformed(fmt::format("the point is of phase {}, which the header does not name", number));
    const bool indexed = v[AngHeader::Confidence] > -1 && v[AngHeader::Phi1] * header_.angle < 12.5;
    if (indexed && known != position_.end()) {
      p.phase = known->second;
      p.orientation = from_bunge(v[AngHeader::Phi1] * header_.angle, v[AngHeader::Phi] * header_.angle,
                                 v[AngHeader::Phi2] * header_.angle);
    }
    return p;
  }

  AngHeader header_;
  const Lines& lines_;
  std::map<int, int> position_;  // in EbsdMap::phases, by the number in the file
  std::size_t expected_ = 0;     // cells of a row
};

}  // namespace

EbsdMap read_ang(std::string_view text, const std::string& file, std::uint64_t memory) {
  Lines lines(text, file);
  const AngHeader header = read_ang_header(lines);
  PointReader reader(header, lines);
  const PointList points = read_points(lines, [&](const std::vector<std::string_view>& cells, PointList& to) {
    if (cells[0].starts_with('#'))
      lines.malformed("a line of a header below points; a file may have one map");
    reader.read(cells, to);
  });
  std::vector<Phase> phases;
  for (const auto& entry : header.phases) phases.push_back(entry.second);
  const Grid grid = find_grid(points, header.grid, memory, lines);
  return rasterize(grid, points, std::move(phases), memory, lines);
}

}  // namespace terrazzo::load_ebsd
