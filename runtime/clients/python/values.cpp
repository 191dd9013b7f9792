// The classes of values.
#include "nodes/data/detail.h"
#include "nodes/data/image.h"
#include "nodes/data/kmatrix.h"
#include "nodes/data/labels.h"
#include "nodes/data/particles.h"
#include "nodes/data/profiles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"
#include "nodes/data/strokes.h"
#include "nodes/data/table.h"
#include "runtime/clients/python/value_views.h"
#include "runtime/hash.h"
#include "runtime/json_text.h"
#include "runtime/report/json_summary.h"

namespace terrazzo::python {

py::object to_python(const Value& v) {
  const std::string& name = v.type().name;
  const auto object = [&]<class O>() { return py::cast(O(v)); };
  if (name == "Image") return object.operator()<ObjectOf<Image>>();
  if (name == "Labels") return object.operator()<ObjectOf<Labels>>();
  if (name == "Profiles") return object.operator()<ObjectOf<Profiles>>();
  if (name == "SizeDistribution") return object.operator()<ObjectOf<SizeDistribution>>();
  if (name == "Shapes") return object.operator()<ObjectOf<Shapes>>();
  if (name == "Particles") return object.operator()<ObjectOf<Particles>>();
  if (name == "Table") return object.operator()<ObjectOf<Table>>();
  if (name == "KMatrix") return object.operator()<ObjectOf<KMatrix>>();
  if (name == "Strokes") return object.operator()<ObjectOf<Strokes>>();
  if (name == "Detail") return object.operator()<ObjectOf<Detail>>();
  if (name == "Volume") return volume_object(v);
  return object.operator()<ValueObject>();  // of a plugin: describe() shows it
}

bool is_value(const py::handle& h) { return py::isinstance<ValueObject>(h); }

const Value& to_value(const py::handle& h) {
  if (!is_value(h))
    throw Error("wrong-type", "expected a value of terrazzo, got " + std::string(Py_TYPE(h.ptr())->tp_name),
                "make one with terrazzo.image, labels, mesh or sizes");
  return h.cast<const ValueObject&>().value;
}

void bind_values(py::module_& m) {
  py::class_<ValueObject>(m, "Value", "A value of a graph.", py::dynamic_attr())
      .def_property_readonly(
          "type", [](const ValueObject& v) { return v.value.type().name; }, "Name of the value's type.")
      .def_property_readonly(
          "content", [](const ValueObject& v) { return content_of(v.value).text(); },
          "Hash of the value's content. Equal values have equal hashes.")
      .def(
          "describe",
          [](const ValueObject& v, bool full) {
            const nlohmann::json all = v.value.type().describe(v.value.data());
            return from_json(json_text(full ? all : summary_json(all)));
          },
          py::arg("full") = false,
          "The value as dictionaries and lists. Long lists are shortened: {'shown': [first entries], 'of': "
          "number}. full: all of it, like `terrazzo show --json`.")
      .def("__eq__",
           [](const ValueObject& a, const py::object& b) {
             if (!is_value(b)) return false;
             const Value& other = to_value(b);
             return a.value.data() == other.data() ||
                    (a.value.type().name == other.type().name && content_of(a.value) == content_of(other));
           })
      .def("__hash__", [](const ValueObject& v) { return content_of(v.value).low; })
      .def("_encoded", [](const ValueObject& v) {
        BufferWriter w;
        v.value.type().encode(v.value.data(), w);
        return py::bytes(w.buffer.data(), w.buffer.size());
      });
  m.def("decoded", [](const std::string& type, const py::bytes& bytes) {
    const ValueType* t = value_types().find(type);
    if (!t) throw Error("wrong-type", "there is no value type '" + type + "'");
    const std::string_view text = bytes;
    Reader r(text.data(), text.size());
    Value v(t, t->decode(r));
    if (r.left() > 0) throw Error("damaged", "the stored value is too long");
    return to_python(v);
  });
  bind_pictures(m);
  bind_profiles(m);
  bind_sizes(m);
  bind_shapes(m);
  bind_particles(m);
  bind_tables(m);
  bind_kmatrix(m);
  bind_strokes(m);
}

}  // namespace terrazzo::python
