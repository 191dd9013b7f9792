#include "nodes/packing/load_particles/field_reader.h"

#include <fmt/format.h>

#include "nodes/common/io/reading.h"

namespace terrazzo::load_particles {

void FieldReader::wrong(const std::string& what) const {
  throw Error("unreadable-file", fmt::format("'{}' {}", file_, what),
              "use a .json file that Export wrote from particles, or that an interrupted packing left")
      .parameter("path");
}

bool FieldReader::key(string_t& name) {
  if (ignored_ > 0) return true;
  field_ = nullptr;
  enter_ = objects_ == 1 && name == "particles";
  for (Field& f : fields_)
    if (name == f.name) field_ = &f;
  if (!field_) return true;
  if (field_->found) wrong(fmt::format("has the field {} twice", field_->name));
  field_->found = true;
  return true;
}

bool FieldReader::number(double v) {
  if (ignored_ > 0 || (objects_ > 0 && !field_)) return true;
  if (!field_) return scalar("a number");
  const int expected = field_->width == 0 ? 0 : field_->width == 1 || field_->flat ? 1 : 2;
  if (lists_ != expected) return scalar("a number");
  field_->numbers.push_back(v);
  return true;
}

bool FieldReader::scalar(const char* what) {
  if (ignored_ > 0 || (objects_ > 0 && !field_)) return true;
  if (objects_ == 0) wrong("is JSON, but not an object with the fields of particles");
  wrong(fmt::format("has {} in the wrong place of the field {}", what, field_->name));
}

bool FieldReader::start_object(std::size_t) {
  if (ignored_ > 0) {
    ++ignored_;
    return true;
  }
  if (field_) return scalar("an object");
  if (enter_) {
    enter_ = false;
    ++objects_;
    return true;
  }
  ++ignored_;
  return true;
}

bool FieldReader::end_object() {
  if (ignored_ > 0)
    --ignored_;
  else {
    --objects_;
    field_ = nullptr;
  }
  // The end of `particles` leads back to the object around it.
  return true;
}

bool FieldReader::start_array(std::size_t) {
  if (ignored_ > 0 || !field_) {
    if (objects_ == 0) return scalar("a list");
    ++ignored_;
    return true;
  }
  const int deepest = field_->width == 0 ? 0 : field_->width == 1 || field_->flat ? 1 : 2;
  if (lists_ == deepest) return scalar("a list");
  ++lists_;
  row_ = field_->numbers.size();
  return true;
}

bool FieldReader::end_array() {
  if (ignored_ > 0) {
    --ignored_;
    return true;
  }
  const bool row = field_->width > 1 && (field_->flat || lists_ == 2);
  const std::size_t length = field_->numbers.size() - row_;
  if (row && length != static_cast<std::size_t>(field_->width))
    wrong(fmt::format("has {} numbers where the field {} needs {}", length, field_->name, field_->width));
  --lists_;
  return true;
}

bool FieldReader::parse_error(std::size_t, const std::string&, const nlohmann::detail::exception& e) {
  std::string why = e.what();
  if (const auto at = why.find("] "); at != std::string::npos) why = why.substr(at + 2);
  wrong("is not JSON: " + printable(why));
}

}  // namespace terrazzo::load_particles
