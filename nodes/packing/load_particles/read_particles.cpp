#include "nodes/packing/load_particles/read_particles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/packing/load_particles/field_reader.h"

namespace terrazzo::load_particles {
namespace {

constexpr double kLargest = 2147483647;  // of shape and class
constexpr double kUnit = 1e-6;           // deviation of an orientation's length from 1

enum { Box, Count, ShapeIndex, Class, Position, Orientation, Scale, Size, Color, BinderColor, Voids };

std::vector<Field> all_fields() {
  return {{"box", 3, true, true},
          {"count", 0},
          {"shape", 1, false, true},
          {"class", 1},
          {"position", 3, false, true},
          {"orientation", 4, false, true},
          {"scale", 1, false, true},
          {"size", 1, false, true},
          {"color", 3},
          {"binder_color", 3, true},
          {"voids", 1}};
}

class Fields {
 public:
  Fields(const std::string& text, std::string file) : file_(std::move(file)), fields_(all_fields()) {
    FieldReader reader(fields_, file_);
    nlohmann::json::sax_parse(text, &reader);
    for (const Field& f : fields_)
      if (f.required && !f.found)
        fail("bad-particles", fmt::format("has no field {}", f.name),
             "Export writes particles with all their fields to .json");
  }

  bool has(int field) const { return fields_[field].found; }
  const std::vector<double>& numbers(int field) const { return fields_[field].numbers; }
  // Rows of a field; `width` numbers each.
  std::size_t rows(int field) const {
    return fields_[field].numbers.size() / std::max(fields_[field].width, 1);
  }
  void require_rows(int field, std::size_t n) const {
    if (has(field) && rows(field) != n)
      fail("bad-particles",
           fmt::format("has {} positions, but {} values of {}", n, rows(field), fields_[field].name));
  }
  std::int32_t index(int field, std::size_t i) const {
    const double v = fields_[field].numbers[i];
    if (!(v >= 0 && v <= kLargest && v == std::floor(v)))
      particle(i, fmt::format("has the {} {}, which is not a whole number ≥ 0", fields_[field].name, v));
    return static_cast<std::int32_t>(v);
  }
  double positive(int field, std::size_t i) const {
    const double v = fields_[field].numbers[i];
    if (!(v > 0)) particle(i, fmt::format("has the {} {}; it must be above 0", fields_[field].name, v));
    return v;
  }
  [[noreturn]] void particle(std::size_t i, const std::string& what) const {
    fail("bad-particle", fmt::format("is wrong: particle {} {}", i, what));
  }
  [[noreturn]] void fail(const char* code, const std::string& what, const std::string& hint = {}) const {
    throw Error(code, fmt::format("'{}' {}", file_, what), hint).parameter("path");
  }

 private:
  std::string file_;
  std::vector<Field> fields_;
};

Vec3 triple(const std::vector<double>& v, std::size_t row) {
  return Vec3(v[3 * row], v[3 * row + 1], v[3 * row + 2]);
}

// A color outside the range of float would become infinite.
Vec3f color(const Fields& f, int field, std::size_t row) {
  const Vec3f c = triple(f.numbers(field), row).cast<float>();
  if (!c.allFinite()) f.fail("bad-particle", "has a color beyond the range of its numbers");
  return c;
}

void read_box(const Fields& f, Particles& p) {
  p.box = triple(f.numbers(Box), 0);
  // Without particles a box may be missing; json has no infinite numbers.
  const bool none = f.rows(Position) == 0 && p.box.isZero(0);
  if (!none && !(p.box.minCoeff() > 0))
    f.fail("bad-box", fmt::format("has a box of {:g} × {:g} × {:g} mm; its edges must be above 0", p.box[0],
                                  p.box[1], p.box[2]));
}

void read_voids(const Fields& f, Particles& p) {
  if (f.rows(Voids) == 0) return;
  p.voids.resize(p.count(), 0);
  double last = -1;
  for (const double v : f.numbers(Voids)) {
    if (!(v > last && v < p.count() && v == std::floor(v)))
      f.fail("bad-particles", fmt::format("has {} in voids after {}; voids are ascending indices below {}", v,
                                          last, p.count()));
    p.voids[last = v] = 1;
  }
}

void read_particle(const Fields& f, Particles& p, std::size_t i) {
  p.shape[i] = f.index(ShapeIndex, i);
  if (f.has(Class)) p.cls[i] = f.index(Class, i);
  p.position[i] = triple(f.numbers(Position), i);
  if (!(p.position[i].minCoeff() >= 0) || !((p.box - p.position[i]).minCoeff() >= 0))
    f.particle(i, fmt::format("is at ({:g}, {:g}, {:g}) mm, outside the box", p.position[i][0],
                              p.position[i][1], p.position[i][2]));
  const double* q = &f.numbers(Orientation)[4 * i];
  p.orientation[i] = Quat(q[0], q[1], q[2], q[3]);
  if (!(std::abs(p.orientation[i].norm() - 1) <= kUnit))
    f.particle(i, "has an orientation that is not a quaternion of length 1");
  p.scale[i] = f.positive(Scale, i);
  p.size[i] = f.positive(Size, i);
  if (f.has(Color)) p.color[i] = color(f, Color, i);
}

}  // namespace

Particles read_particles(const std::string& text, const std::string& file) {
  const Fields f(text, file);
  const std::size_t n = f.rows(Position);
  for (const int field : {ShapeIndex, Class, Orientation, Scale, Size, Color}) f.require_rows(field, n);
  if (f.has(Count) && (f.rows(Count) != 1 || f.numbers(Count)[0] != n))
    f.fail("bad-particles", fmt::format("has {} positions, but another count", n));
  if (n > kLargest) f.fail("bad-particles", "has too many particles");
  Particles p;
  read_box(f, p);
  p.resize(n);
  for (std::size_t i = 0; i < n; ++i) read_particle(f, p, i);
  if (f.has(BinderColor)) p.binder_color = color(f, BinderColor, 0);
  read_voids(f, p);
  return p;
}

// Each number needs a character and a comma. It is stored as 8 bytes, three times while its list grows, and
// once more in the particles. Names and texts are copied while they are read.
double memory_to_read(const std::string& text) {
  const double commas = std::count(text.begin(), text.end(), ',');
  return 3.0 * text.size() + 32.0 * (commas + 1);
}

}  // namespace terrazzo::load_particles
