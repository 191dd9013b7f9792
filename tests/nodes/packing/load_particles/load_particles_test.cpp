// Packings that are written and loaded again, and files that are no packings.
#include <gtest/gtest.h>

#include "nodes/common/io/particles_json.h"
#include "nodes/data/table.h"
#include "nodes/packing/load_particles/read_particles.h"
#include "runtime/files.h"
#include "runtime/json_text.h"
#include "tests/nodes/packing/load_particles/particles_support.h"
#include "tests/support/code_of.h"
#include "tests/support/stored_values.h"

namespace terrazzo {
namespace {
using namespace load_particles;

nlohmann::json described(const Particles& p) { return value_type<Particles>().describe(&p); }

Particles exported(const Particles& p) {
  const auto folder = test::temporary_folder();
  test::run_node("Export", {{"particles", Value::of<Particles>(p)}}, {{"path", "p.json"}}, folder);
  return test::loaded(folder / "p.json");
}

Particles written(const Particles& p) {
  const auto file = test::temporary_folder() / "p.json";
  write_particles_json(file, p);
  return test::loaded(file);
}

TEST(LoadParticles, ReadsWhatExportWroteBitForBit) {
  const Particles p = test::awkward_particles();
  EXPECT_EQ(test::bytes_of(exported(p)), test::bytes_of(p));
}

TEST(LoadParticles, ReadsWhatAnInterruptedPackingWroteBitForBit) {
  const Particles p = test::awkward_particles();
  EXPECT_EQ(test::bytes_of(written(p)), test::bytes_of(p));
}

TEST(LoadParticles, BothWritersWriteTheSameFields) {
  const auto file = test::temporary_folder() / "p.json";
  for (const Particles& p : {test::awkward_particles(), Particles{}}) {
    write_particles_json(file, p);
    EXPECT_EQ(nlohmann::json::parse(*read_file(file)), described(p));
  }
}

TEST(LoadParticles, ReadsABoxWithoutParticles) {
  Particles p;
  EXPECT_EQ(test::bytes_of(exported(p)), test::bytes_of(p));
  p.box = Vec3(1, 2, 3), p.binder_color = Vec3f(0.1f, 0.2f, 0.3f);
  EXPECT_EQ(test::bytes_of(exported(p)), test::bytes_of(p));
  EXPECT_EQ(test::bytes_of(written(p)), test::bytes_of(p));
}

TEST(LoadParticles, AListOfVoidsWithoutAnyIsNone) {
  Particles p = test::awkward_particles();
  p.voids = {0, 0, 0};
  EXPECT_EQ(test::bytes_of(exported(p)), test::bytes_of(p));
  p.voids.clear();
  EXPECT_EQ(test::bytes_of(exported(p)), test::bytes_of(p));
}

TEST(LoadParticles, ReadsParticlesWrittenWithOtherValues) {
  const Particles p = test::awkward_particles();
  const Table table{{"x"}, {{1.0}}};
  const auto folder = test::temporary_folder();
  test::run_node("Export", {{"particles", Value::of<Particles>(p)}, {"table", Value::of<Table>(table)}},
                 {{"path", "both.json"}}, folder);
  EXPECT_EQ(test::bytes_of(test::loaded(folder / "both.json")), test::bytes_of(p));
}

TEST(LoadParticles, FillsInWhatMayBeMissing) {
  const Particles p = read_particles(
      R"({"box": [1, 2, 3], "shape": [4], "position": [[0.5, 0.5, 0.5]], "orientation": [[1, 0, 0, 0]],
          "scale": [1], "size": [2], "comment": {"box": [[[]]], "x": [1, {"shape": null}]}, "tags": [true, "a"]})",
      "p.json");
  ASSERT_EQ(p.count(), 1u);
  EXPECT_EQ(p.box, Vec3(1, 2, 3));
  EXPECT_EQ(p.shape[0], 4);
  EXPECT_EQ(p.cls[0], 0);
  EXPECT_EQ(p.color[0], Vec3f::Constant(0.5f));
  EXPECT_EQ(p.binder_color, Vec3f::Zero());
  EXPECT_TRUE(p.voids.empty());
}

// A valid file of two particles with one field replaced, or removed if `value` is empty.
std::string file_of(const std::string& field, const std::string& value) {
  std::map<std::string, std::string> fields = {{"box", "[1, 1, 1]"},
                                               {"count", "2"},
                                               {"shape", "[0, 0]"},
                                               {"class", "[0, 0]"},
                                               {"position", "[[0, 0, 0], [1, 1, 1]]"},
                                               {"orientation", "[[1, 0, 0, 0], [0, 0, 0, 1]]"},
                                               {"scale", "[1, 1]"},
                                               {"size", "[1, 1]"},
                                               {"color", "[[0, 0, 0], [1, 1, 1]]"},
                                               {"binder_color", "[0, 0, 0]"},
                                               {"voids", "[1]"}};
  fields[field] = value;
  std::string text;
  for (const auto& [name, v] : fields)
    if (!v.empty()) text += (text.empty() ? "{\"" : ", \"") + name + "\": " + v;
  return text + "}";
}

std::string code_of_text(const std::string& text) {
  return test::code_of([&] { read_particles(text, "p.json"); });
}
std::string code_with(const std::string& field, const std::string& value) {
  return code_of_text(file_of(field, value));
}

TEST(LoadParticles, RejectsAnotherStructure) {
  EXPECT_EQ(code_of_text(file_of("none", "")), "");
  for (const char* text : {"", "nonsense", "{", "[]", "3", "null", "\"box\"", "{\"box\": [1, 1, 1}", "{}{}",
                           "x,y,z\n1,2,3\n", "\xff\xfe", "{\"\xff\": 1}"})
    EXPECT_EQ(code_of_text(text), "unreadable-file") << text;
  for (const char* field : {"box", "shape", "position", "orientation", "scale", "size", "class", "color"}) {
    for (const char* value :
         {"1", "null", "\"[1, 1, 1]\"", "{}", "[[[1, 1, 1]]]", "[null, null]", "[1e999, 1]"})
      EXPECT_EQ(code_with(field, value), "unreadable-file") << field << " " << value;
  }
  EXPECT_EQ(code_with("position", "[[0, 0], [1, 1]]"), "unreadable-file");
  EXPECT_EQ(code_with("orientation", "[[1, 0, 0, 0], [0, 0, 1]]"), "unreadable-file");
  EXPECT_EQ(code_with("box", "[1, 1]"), "unreadable-file");
  EXPECT_EQ(code_with("count", "[2]"), "unreadable-file");
  EXPECT_EQ(code_of_text(R"({"box": [1, 1, 1], "box": [2, 2, 2]})"), "unreadable-file");
}

TEST(LoadParticles, RejectsMissingAndUnequalFields) {
  for (const char* field : {"box", "shape", "position", "orientation", "scale", "size"})
    EXPECT_EQ(code_with(field, ""), "bad-particles") << field;
  for (const char* field : {"class", "color", "count", "binder_color", "voids"})
    EXPECT_EQ(code_with(field, ""), "") << field;
  for (const char* field : {"shape", "class", "scale", "size"}) {
    EXPECT_EQ(code_with(field, "[1]"), "bad-particles") << field;
    EXPECT_EQ(code_with(field, "[1, 1, 1]"), "bad-particles") << field;
  }
  EXPECT_EQ(code_with("position", "[[0, 0, 0]]"), "bad-particles");
  EXPECT_EQ(code_with("orientation", "[]"), "bad-particles");
  EXPECT_EQ(code_with("count", "3"), "bad-particles");
}

TEST(LoadParticles, RejectsValuesThatNoPackingHas) {
  for (const char* box : {"[0, 1, 1]", "[1, -1, 1]", "[0, 0, 0]"})
    EXPECT_EQ(code_with("box", box), "bad-box") << box;
  for (const char* field : {"shape", "class"})
    for (const char* value : {"[-1, 0]", "[0, 0.5]", "[0, 2147483648]", "[0, 1e300]"})
      EXPECT_EQ(code_with(field, value), "bad-particle") << field << value;
  for (const char* field : {"scale", "size"})
    for (const char* value : {"[0, 1]", "[1, -1]"})
      EXPECT_EQ(code_with(field, value), "bad-particle") << field << value;
  EXPECT_EQ(code_with("position", "[[0, 0, 0], [1.0001, 1, 1]]"), "bad-particle");
  EXPECT_EQ(code_with("position", "[[-1e-9, 0, 0], [1, 1, 1]]"), "bad-particle");
  EXPECT_EQ(code_with("orientation", "[[1, 0, 0, 0], [0, 0, 0, 0]]"), "bad-particle");
  EXPECT_EQ(code_with("orientation", "[[1, 0, 0, 0.1], [1, 0, 0, 0]]"), "bad-particle");
  EXPECT_EQ(code_with("color", "[[0, 0, 0], [1e300, 1, 1]]"), "bad-particle");
  for (const char* voids : {"[2]", "[-1]", "[0.5]", "[1, 0]", "[1, 1]"})
    EXPECT_EQ(code_with("voids", voids), "bad-particles") << voids;
}

TEST(LoadParticles, NamesTheFileAndTheParticle) {
  try {
    read_particles(file_of("scale", "[1, -2]"), "p.json");
    ADD_FAILURE() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().message, "'p.json' is wrong: particle 1 has the scale -2; it must be above 0");
  }
}

// Nesting takes neither stack nor memory beyond the text, and a file beyond the budget is refused.
TEST(LoadParticles, HostileTextsEndWithAnError) {
  const std::string open(3'000'000, '[');
  for (const char* before : {"", "{\"x\": ", "{\"position\": ", "{\"particles\": "})
    EXPECT_EQ(code_of_text(before + open), "unreadable-file") << before;
  std::string objects;
  for (int i = 0; i < 300'000; ++i) objects += "{\"particles\":";
  EXPECT_EQ(code_of_text(objects), "unreadable-file");
  EXPECT_EQ(code_of_text("{\"" + std::string(3'000'000, 'a')), "unreadable-file");
  EXPECT_EQ(code_of_text("{\"box\": [" + std::string(3'000'000, '9') + "]}"), "unreadable-file");
  EXPECT_GE(memory_to_read(std::string(1000, ',')), 32'000);
}

TEST(LoadParticles, NeedsOneFile) {
  const auto folder = test::temporary_folder();
  for (const char* name : {"a.json", "b.json"}) write_particles_json(folder / name, Particles{});
  const auto load = [&] { test::loaded(folder / "*.json"); };
  EXPECT_EQ(test::code_of(load), "several-files");
}

}  // namespace
}  // namespace terrazzo
