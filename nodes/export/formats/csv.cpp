#include "nodes/export/formats/csv.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "graph/diagnostic.h"
#include "graph/text/utf8.h"
#include "nodes/common/stereology/profile_columns.h"
#include "nodes/data/indices.h"

namespace terrazzo::exporting {
namespace {

class Lines {
 public:
  explicit Lines(const std::vector<std::string>& header) {
    for (const auto& h : header) word(h);
    end();
  }
  void number(double v) { cell(fmt::format("{}", v)); }
  // Empty if unknown.
  void measure(double v) { cell(std::isnan(v) ? "" : fmt::format("{}", v)); }
  void number(float v) { cell(fmt::format("{}", v)); }
  void integer(std::int64_t v) { cell(fmt::format("{}", v)); }
  void word(const std::string& text) {
    const std::string s = escape_controls(text);
    if (s.find_first_of(",\"\r\n") == std::string::npos) return cell(s);
    std::string quoted = "\"";
    for (const char c : s) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    cell(quoted + '"');
  }
  template <class V>
  void vector(const V& v) {
    for (Eigen::Index i = 0; i < v.size(); ++i) number(v[i]);
  }
  void end() {
    text_ += '\n';
    first_ = true;
  }
  std::string take() { return std::move(text_); }

 private:
  void cell(const std::string& s) {
    if (!first_) text_ += ',';
    text_ += s;
    first_ = false;
  }
  std::string text_;
  bool first_ = true;
};

// In mm, then in pixels, then colors, as far as the picture is known.
std::vector<ProfileColumn> measured_columns(const Profiles& profiles, const ProfilePicture& picture,
                                            const Work& work) {
  std::vector<ProfileColumn> out = profile_columns(profiles, work), pixels;
  if (picture.pixel_size > 0) {
    pixels = out;
    pixels.insert(pixels.begin(), {"area", 2, {}});
    for (const Profile& p : profiles.profiles) pixels[0].values.push_back(p.area);
  }
  for (ProfileColumn& c : pixels) {
    if (c.power == 0) continue;
    for (double& v : c.values) v /= std::pow(picture.pixel_size, c.power);
    out.push_back({c.name + "_px", 0, std::move(c.values)});
  }
  if (!picture.image) return out;
  const std::vector<Vec3f> colors = mean_colors(profiles, *picture.image, work);
  for (int k = 0; k < 3; ++k) {
    out.push_back({std::string("mean_") + "rgb" [k], 0, {}});
    for (const Vec3f& color : colors) out.back().values.push_back(color[k]);
  }
  if (const auto& place = picture.image->georeference)
    for (int k = 0; k < 2; ++k) {
      out.push_back({std::string("map_") + "xy" [k], 0, {}});
      for (const Profile& p : profiles.profiles) {
        const Vec2 pixel(p.centroid.x() / picture.pixel_size,
                         picture.image->height - p.centroid.y() / picture.pixel_size);
        out.back().values.push_back(place->on_map(pixel)[k]);
      }
    }
  return out;
}

}  // namespace

std::string csv_of(const Table& table) {
  Lines out(table.columns);
  for (const auto& row : table.rows) {
    for (const auto& cell : row) {
      if (const auto* v = std::get_if<double>(&cell))
        out.number(*v);
      else
        out.word(std::get<std::string>(cell));
    }
    out.end();
  }
  return out.take();
}

std::string csv_of(const Profiles& profiles, const ProfilePicture& picture, const Work& work) {
  std::vector<std::string> header = {"section",    "class",          "area",   "centroid_x",
                                     "centroid_y", "touches_border", "weight", "confidence",
                                     "color_r",    "color_g",        "color_b"};
  // A cut is what a table without these columns is taken for.
  const bool cut = profiles.view == View::Section;
  if (!cut) header.insert(header.end(), {"whole", "view"});
  const std::vector<ProfileColumn> columns = measured_columns(profiles, picture, work);
  for (const ProfileColumn& c : columns) header.push_back(c.name);
  Lines out(header);
  std::size_t row = 0;
  for (const auto& p : profiles.profiles) {
    out.integer(p.section);
    out.integer(p.cls);
    out.number(p.area);
    out.vector(p.centroid);
    out.integer(p.touches_border);
    out.number(p.weight);
    out.number(p.confidence);
    out.vector(p.color);
    if (!cut) {
      out.number(p.whole);
      out.word(name_of(profiles.view));
    }
    for (const ProfileColumn& c : columns) out.measure(c.values[row]);
    ++row;
    out.end();
  }
  return out.take();
}

std::string csv_of(const Particles& particles, const Shapes* shapes) {
  std::vector<std::string> header = {"id", "shape", "class", "x",    "y",       "z",       "qw",      "qx",
                                     "qy", "qz",    "scale", "size", "color_r", "color_g", "color_b", "void"};
  if (shapes) header.emplace_back("equivalent_diameter");
  Lines out(header);
  for (std::size_t i = 0; i < particles.count(); ++i) {
    out.integer(i);
    out.integer(particles.shape[i]);
    out.integer(particles.cls[i]);
    out.vector(particles.position[i]);
    out.number(particles.orientation[i].w());
    out.vector(particles.orientation[i].vec());
    out.number(particles.scale[i]);
    out.number(particles.size[i]);
    out.vector(particles.color[i]);
    out.integer(particles.is_void(i));
    if (shapes) {
      if (particles.shape[i] < 0 || particles.shape[i] >= count_of(shapes->shapes))
        throw Error("no-such-shape",
                    fmt::format("particle {} has shape {}, but there are {} shapes", i, particles.shape[i],
                                shapes->shapes.size()),
                    "connect the shapes used in the packing");
      out.number(particles.scale[i] *
                 std::cbrt(6 / std::numbers::pi * shapes->shapes[particles.shape[i]].volume));
    }
    out.end();
  }
  return out.take();
}

std::string csv_of(const SizeDistribution& distribution) {
  Lines out({"shape", "class", "size_low", "size_high", "N_V", "low", "high"});
  for (const auto& entry : distribution.shapes)
    for (std::size_t k = 0; k < entry.N_V.size(); ++k) {
      out.integer(entry.shape);
      out.integer(entry.cls);
      out.number(distribution.class_edges.at(k));
      out.number(distribution.class_edges.at(k + 1));
      out.number(entry.N_V[k]);
      out.number(entry.low.at(k));
      out.number(entry.high.at(k));
      out.end();
    }
  return out.take();
}

std::string csv_of(const KMatrix& kmatrix) {
  std::vector<std::string> header = {"shape", "profile_class"};
  for (int j = 1; j <= kmatrix.classes; ++j) header.push_back("size_" + std::to_string(j));
  Lines out(header);
  for (std::size_t s = 0; s < kmatrix.shapes.size(); ++s)
    for (Eigen::Index i = 0; i < kmatrix.shapes[s].K.rows(); ++i) {
      out.integer(s);
      out.integer(i + 1);
      for (Eigen::Index j = 0; j < kmatrix.shapes[s].K.cols(); ++j) out.number(kmatrix.shapes[s].K(i, j));
      out.end();
    }
  return out.take();
}

std::string csv_of(const Shapes& shapes) {
  Lines out({"name", "probability", "vertices", "triangles", "volume", "surface_area", "mean_caliper",
             "max_section_area"});
  for (const auto& s : shapes.shapes) {
    out.word(s.name);
    out.number(s.probability);
    out.integer(s.mesh.vertices.size());
    out.integer(s.mesh.triangles.size());
    out.number(s.volume), out.number(s.surface_area), out.number(s.mean_caliper),
        out.number(s.max_section_area);
    out.end();
  }
  return out.take();
}

}  // namespace terrazzo::exporting
