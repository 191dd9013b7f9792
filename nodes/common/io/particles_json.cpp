#include "nodes/common/io/particles_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "nodes/common/io/checked_file.h"
#include "runtime/work.h"

namespace terrazzo {
namespace {

constexpr std::size_t kRange = 4096, kBlock = 64 * kRange;  // values formatted by one thread, and at once

void add_number(std::string& text, double v) {
  if (!std::isfinite(v)) {
    text += "null";  // as in every JSON file
    return;
  }
  const auto before = text.size();
  fmt::format_to(std::back_inserter(text), "{}", v);
  if (v == 0 && text.size() == before + 2) text += ".0";  // -0 would be read as the integer 0
}
void add_number(std::string& text, std::int32_t v) { fmt::format_to(std::back_inserter(text), "{}", v); }
void add_number(std::string& text, std::size_t v) { fmt::format_to(std::back_inserter(text), "{}", v); }

template <class... T>
void add_row(std::string& text, T... v) {
  text += '[';
  bool first = true;
  ((text += first ? "" : ",", first = false, add_number(text, v)), ...);
  text += ']';
}

class Json {
 public:
  explicit Json(std::ostream& out) : out_(out) {}

  // A field with write(text).
  template <class Write>
  void field(const char* name, Write&& write) {
    std::string text = std::string(first_ ? "{\n\"" : ",\n\"") + name + "\": ";
    write(text);
    out_ << text;
    first_ = false;
  }
  // A field with a list of write(text, i) for all i in [0, n).
  template <class Write>
  void list(const char* name, std::size_t n, Write&& write) {
    field(name, [](std::string& text) { text += '['; });
    for (std::size_t at = 0; at < n; at += kBlock) {
      const std::size_t end = std::min(n, at + kBlock);
      std::vector<std::string> texts((end - at + kRange - 1) / kRange);
      Work().parallel(end - at, kRange, [&](std::size_t from, std::size_t to) {
        std::string& text = texts[from / kRange];
        for (std::size_t i = at + from; i < at + to; ++i) {
          if (i > 0) text += ',';
          write(text, i);
        }
      });
      for (const auto& text : texts) out_ << text;
    }
    out_ << ']';
  }
  template <class T>
  void list(const char* name, const std::vector<T>& values) {
    list(name, values.size(), [&](std::string& text, std::size_t i) { add_number(text, values[i]); });
  }
  void end() { out_ << "\n}\n"; }

 private:
  std::ostream& out_;
  bool first_ = true;
};

// As double: the shortest text of a float might not read back to it through a double.
void add_color(std::string& text, const Vec3f& c) { add_row(text, double(c[0]), double(c[1]), double(c[2])); }
void add_vector(std::string& text, const Vec3& v) { add_row(text, v[0], v[1], v[2]); }

void write_particles(std::ostream& out, const Particles& p) {
  const std::size_t n = p.count();
  std::vector<std::size_t> voids;
  for (std::size_t i = 0; i < n; ++i)
    if (p.is_void(i)) voids.push_back(i);
  Json j(out);
  j.field("box", [&](std::string& text) { add_vector(text, p.box); });
  j.field("count", [&](std::string& text) { add_number(text, n); });
  j.list("shape", p.shape);
  j.list("class", p.cls);
  j.list("position", n, [&](std::string& text, std::size_t i) { add_vector(text, p.position[i]); });
  j.list("orientation", n, [&](std::string& text, std::size_t i) {
    const Quat& q = p.orientation[i];
    add_row(text, q.w(), q.x(), q.y(), q.z());
  });
  j.list("scale", p.scale);
  j.list("size", p.size);
  j.list("color", n, [&](std::string& text, std::size_t i) { add_color(text, p.color[i]); });
  j.field("binder_color", [&](std::string& text) { add_color(text, p.binder_color); });
  j.list("voids", voids);
  j.end();
}

void add_shape(std::string& text, const Shape& s) {
  text +=
      "{\"name\": " + nlohmann::json(s.name).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  const auto number = [&](const char* name, auto v) {
    text += std::string(", \"") + name + "\": ";
    add_number(text, v);
  };
  number("probability", s.probability);
  number("class", static_cast<std::int32_t>(s.cls));
  if (!s.trend.even()) {
    text += ", \"trend\": ";
    add_row(text, s.trend.power, s.trend.size, s.trend.spread);
  }
  number("volume", s.volume);
  number("surface_area", s.surface_area);
  number("mean_caliper", s.mean_caliper);
  number("max_section_area", s.max_section_area);
  text += std::string(", \"smooth\": ") + (s.smooth ? "true" : "false") + ", \"mesh\": {\"vertices\": [";
  for (std::size_t k = 0; k < s.mesh.vertices.size(); ++k) {
    if (k > 0) text += ',';
    add_vector(text, s.mesh.vertices[k]);
  }
  text += "], \"triangles\": [";
  for (std::size_t k = 0; k < s.mesh.triangles.size(); ++k) {
    if (k > 0) text += ',';
    add_row(text, s.mesh.triangles[k][0], s.mesh.triangles[k][1], s.mesh.triangles[k][2]);
  }
  text += "]}}";
}

void write_shapes(std::ostream& out, const Shapes& shapes) {
  constexpr std::size_t kAtOnce = 256;
  out << "{\n\"shapes\": [";
  for (std::size_t at = 0; at < shapes.shapes.size(); at += kAtOnce) {
    std::vector<std::string> texts(std::min(kAtOnce, shapes.shapes.size() - at));
    Work().parallel(texts.size(), 8, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        texts[i] = at + i > 0 ? ",\n" : "\n";
        add_shape(texts[i], shapes.shapes[at + i]);
      }
    });
    for (const std::string& text : texts) out << text;
  }
  out << "]\n}";
}

}  // namespace

void write_particles_json(const std::filesystem::path& path, const Particles& p) {
  CheckedFile file(path);
  file.guard([&](std::ostream& out) { write_particles(out, p); });
}

void write_packing_json(const std::filesystem::path& path, const Particles& p, const Shapes& shapes) {
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    out << "{\n\"particles\": ";
    write_particles(out, p);
    out << ",\n\"shapes\": ";
    write_shapes(out, shapes);
    out << "\n}\n";
  });
}

}  // namespace terrazzo
