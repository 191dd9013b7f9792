#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"
#include "nodes/shapes/shape_estimate/methods/method.h"
#include "nodes/shapes/shape_estimate/methods/morph_frame.h"
#include "nodes/shapes/shape_estimate/subdivide.h"

namespace terrazzo::shape_estimate {

namespace {

// Number of subdivision levels for which an edge stays sharp: worn edges with barely the angle of a
// corner become rounded sooner.
double sharpness(double corner_degrees) {
  const double a = std::abs(corner_degrees);
  return a == 0 ? 0 : std::clamp(a / 20, 1.0, 5.0);
}

// One side of the base plane as a grid: rows from the pole (0) to the base (`rows`), columns around the axis.
struct Side {
  std::vector<std::vector<Vec3>> points;        // [row][column]
  std::vector<std::vector<double>> row_crease;  // [row][column]: of the edge to the next column
};

// Where an arc is evaluated: at equal arc lengths, or moved to its corners, which then become creases.
std::vector<double> parameters_of(const Arc& arc, int spans, Tessellation tessellation) {
  if (tessellation == Tessellation::Fitted) return knots(arc, spans);
  std::vector<double> even(spans + 1);
  for (int i = 0; i <= spans; ++i) even[i] = static_cast<double>(i) / spans;
  return even;
}

struct Columns {
  std::vector<std::size_t> sector;
  std::vector<double> t;         // within the sector, by the base's arc length
  std::vector<double> fraction;  // within the sector, by column number
  std::vector<Vec2> point;       // of the base
  std::vector<double> crease;    // of the base's corner there
};

Columns columns_of(const MorphFrame& frame, int spans, Tessellation tessellation) {
  Columns c;
  for (std::size_t j = 0; j < frame.base.size(); ++j) {
    const auto k = parameters_of(frame.base[j], spans, tessellation);
    for (int i = 0; i < spans; ++i) {
      c.sector.push_back(j);
      c.t.push_back(k[i]);
      c.fraction.push_back(static_cast<double>(i) / spans);
      c.point.push_back(frame.base[j].at(k[i]));
      // A corner at a half-plane may be just on its other side.
      double corner = frame.base[j].corner_at(k[i], 0.1 / spans);
      if (i == 0) {
        const double before =
            frame.base[(j + frame.base.size() - 1) % frame.base.size()].corner_at(1, 0.1 / spans);
        if (std::abs(before) > std::abs(corner)) corner = before;
      }
      c.crease.push_back(sharpness(corner));
    }
  }
  return c;
}

// Eq. 1 on the neighboring morph curves, m = (1 − t_b) m₀ + t_b m₁, swept along the base. Direct points have
// equal arc lengths on both; fitted ones pair the knots of both, so that corners meet.
Side side_of(const MorphFrame& frame, const std::vector<Arc>& arcs, const Columns& columns, int rows,
             Tessellation tessellation) {
  const std::size_t n = columns.t.size(), sectors = arcs.size();
  std::vector<std::vector<double>> t(sectors), sharp(sectors);
  for (std::size_t j = 0; j < sectors; ++j) {
    t[j] = parameters_of(arcs[j], rows, tessellation);
    for (int r = 0; r <= rows; ++r) sharp[j].push_back(sharpness(arcs[j].corner_at(t[j][r], 0.1 / rows)));
  }
  Side side;
  side.points.assign(rows + 1, std::vector<Vec3>(n));
  side.row_crease.assign(rows + 1, std::vector<double>(n, 0));
  for (int r = 0; r <= rows; ++r)
    for (std::size_t c = 0; c < n; ++c) {
      const std::size_t j = columns.sector[c], k = (j + 1) % sectors;
      const double w = columns.t[c];
      const Vec2 m = (1 - w) * arcs[j].at(t[j][r]) + w * arcs[k].at(t[k][r]);
      const double reach = (1 - w) * frame.radius[j] + w * frame.radius[k];
      const Vec2 b = columns.point[c] * (m.x() / reach);
      side.points[r][c] = {b.x(), b.y(), m.y()};
      const double next = c + 1 < n && columns.sector[c + 1] == j ? columns.fraction[c + 1] : 1;
      const double middle = (columns.fraction[c] + next) / 2;
      side.row_crease[r][c] = (1 - middle) * sharp[j][r] + middle * sharp[k][r];
    }
  return side;
}

ControlMesh control_mesh(const Side& upper, const Side& lower, const Columns& columns, int rows) {
  const int n = columns.t.size(), rings = 2 * rows - 1;
  ControlMesh mesh;
  mesh.vertices.push_back(upper.points[0][0]);
  const auto ring = [&](int i) -> const std::vector<Vec3>& {
    return i < rows ? upper.points[i + 1] : lower.points[2 * rows - 1 - i];
  };
  const auto ring_crease = [&](int i) -> const std::vector<double>& {
    return i < rows ? upper.row_crease[i + 1] : lower.row_crease[2 * rows - 1 - i];
  };
  for (int i = 0; i < rings; ++i) mesh.vertices.insert(mesh.vertices.end(), ring(i).begin(), ring(i).end());
  const int south = mesh.vertices.size();
  mesh.vertices.push_back(lower.points[0][0]);
  const auto at = [&](int i, int c) { return 1 + i * n + (c % n); };
  const auto crease = [&](int a, int b, double s) {
    if (s < 0.05) return;
    mesh.crease_edges.push_back({a, b});
    mesh.crease_sharpness.push_back(static_cast<float>(s));
  };
  for (int c = 0; c < n; ++c) {
    mesh.faces.push_back({0, at(0, c), at(0, c + 1)});
    mesh.faces.push_back({south, at(rings - 1, c + 1), at(rings - 1, c)});
    for (int i = 0; i + 1 < rings; ++i) {
      mesh.faces.push_back({at(i, c), at(i + 1, c), at(i + 1, c + 1), at(i, c + 1)});
      crease(at(i, c), at(i + 1, c), columns.crease[c]);
    }
    for (int i = 0; i < rings; ++i) {
      double s = ring_crease(i)[c];
      if (i == rows - 1) s = std::max(s, lower.row_crease[rows][c]);
      crease(at(i, c), at(i, c + 1), s);
    }
  }
  return mesh;
}

// Use the fewest control points that reproduce the profiles to this share of their diameter.
constexpr double kDeviation = 0.008;

ControlMesh swept_grid(const MorphFrame& frame, int spans, int rows, Tessellation tessellation) {
  const Columns columns = columns_of(frame, spans, tessellation);
  const Side upper = side_of(frame, frame.upper, columns, rows, tessellation),
             lower = side_of(frame, frame.lower, columns, rows, tessellation);
  return control_mesh(upper, lower, columns, rows);
}

Mesh fitted_surface(const MorphFrame& frame, int control, int subdivision, const Work& work) {
  const int sectors = frame.base.size();
  const int spans = std::max(2, (4 * control + sectors / 2) / sectors);
  return interpolating_surface(swept_grid(frame, spans, control, Tessellation::Fitted), subdivision, 20,
                               work);
}

bool is_smooth(const EstimateRequest& request) {
  int corners = 0;
  for (const auto& o : request.chosen) corners += o.corners;
  return corners < 3 * count_of(request.chosen);
}

// Splits quadrilaterals along their shorter diagonal.
Mesh direct_surface(const MorphFrame& frame, int subdivision) {
  const int quarter = 8 << subdivision, sectors = frame.base.size();
  ControlMesh grid = swept_grid(frame, std::max(2, 4 * quarter / sectors), quarter, Tessellation::Direct);
  Mesh mesh;
  mesh.vertices = std::move(grid.vertices);
  const auto far = [&](int a, int b) { return (mesh.vertices[a] - mesh.vertices[b]).squaredNorm(); };
  for (const auto& f : grid.faces) {
    const int turn = f.size() == 4 && far(f[1], f[3]) < far(f[0], f[2]);
    for (std::size_t i = 2; i < f.size(); ++i)
      mesh.triangles.push_back({f[turn], f[(i - 1 + turn) % f.size()], f[(i + turn) % f.size()]});
  }
  return mesh;
}

}  // namespace

Estimate swept_surface(const MorphFrame& frame, const EstimateRequest& request, const Work& work) {
  Estimate out;
  if (request.tessellation == Tessellation::Direct) {
    out.mesh = direct_surface(frame, request.subdivision);
    out.deviation = frame_deviation(frame, out.mesh);
    out.smooth = is_smooth(request);
    return out;
  }
  // A finer tessellation implies that more of the profiles should be preserved.
  const int most = request.control           ? request.control
                   : request.subdivision < 2 ? 4 + 2 * request.subdivision
                                             : 24;
  for (int control = request.control ? request.control : 3; control <= most;) {
    work.check();
    // A fine control grid needs less subdivision for an equally fine surface.
    const int level =
        !request.control && control > 10 ? std::min(request.subdivision, 1) : request.subdivision;
    Mesh mesh = fitted_surface(frame, control, level, work);
    const double deviation = frame_deviation(frame, mesh);
    if (out.deviation < 0 || deviation < out.deviation) {
      out.mesh = std::move(mesh);
      out.deviation = deviation;
    }
    if (deviation < kDeviation || control == most) break;
    // Extrapolate to the number that would suffice if the deviation fell with its square.
    control = std::clamp<int>(control * std::sqrt(deviation / kDeviation), control + 1, most);
  }
  out.smooth = is_smooth(request);
  return out;
}

Estimate morphed_generalized_cylinder(const EstimateRequest& request, const Work& work) {
  return swept_surface(morph_frame(request.chosen, request.axis, request.base), request, work);
}

}  // namespace terrazzo::shape_estimate
