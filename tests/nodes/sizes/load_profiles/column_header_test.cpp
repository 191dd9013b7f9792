#include "nodes/sizes/load_profiles/column_header.h"

#include <gtest/gtest.h>

#include "nodes/sizes/load_profiles/profile_table.h"

#include <fstream>
#include <numbers>

#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace load_profiles;

TEST(ColumnHeader, UnitsHaveManySpellings) {
  struct Case {
    const char* text;
    double mm;
    int power;
  };
  for (const Case& c : std::initializer_list<Case>{{"mm", 1, 0},
                                                   {"µm²", 1e-3, 2},
                                                   {"μm²", 1e-3, 2},
                                                   {"um^2", 1e-3, 2},
                                                   {"um2", 1e-3, 2},
                                                   {"µm**2", 1e-3, 2},
                                                   {"µm^{2}", 1e-3, 2},
                                                   {"sq. µm", 1e-3, 2},
                                                   {"sq mm", 1, 2},
                                                   {"square microns", 1e-3, 2},
                                                   {"µm squared", 1e-3, 2},
                                                   {"µm x µm", 1e-3, 2},
                                                   {"µm*µm", 1e-3, 2},
                                                   {"microns", 1e-3, 0},
                                                   {"Micrometers", 1e-3, 0},
                                                   {"nm", 1e-6, 0},
                                                   {"NM²", 1e-6, 2},
                                                   {"cm2", 10, 2},
                                                   {"m", 1000, 0},
                                                   {"m²", 1000, 2},
                                                   {"mm³", 1, 3},
                                                   {"inches", 25.4, 0},
                                                   {"Å", 1e-7, 0},
                                                   {"px", 0, 0},
                                                   {"pixels²", 0, 2}}) {
    const auto unit = unit_of(c.text);
    ASSERT_TRUE(unit) << c.text;
    EXPECT_DOUBLE_EQ(unit->mm, c.mm) << c.text;
    EXPECT_EQ(unit->power, c.power) << c.text;
  }
  for (const char* text : {"", "filled", "%", "2", "10³ µm²", "µm²/px", "s", "mean"})
    EXPECT_FALSE(unit_of(text)) << text;
}

TEST(ColumnHeader, NamesAndUnitsAreParted) {
  const auto said = [](const std::string& text) {
    const ColumnHeader h = read_header(text);
    return h.name + "|" + (h.unit ? std::to_string(h.unit->power) : h.unit_text.empty() ? "-" : "?");
  };
  for (const char* text :
       {"Area (µm²)", "AREA [um^2]", "area_um2", "Area µm²", "Area / µm²", "Area, µm²", "area.um2",
        "Area in µm²", "Area {µm2}", "Area (filled) [µm²]", " Area(µm²) ", "Area sq. µm"})
    EXPECT_EQ(said(text), "area|2") << text;
  EXPECT_EQ(said("Equivalent diameter [um]"), "equivalentdiameter|0");
  EXPECT_EQ(said("Area"), "area|-");
  EXPECT_EQ(said("Area (filled)"), "area|-");
  EXPECT_EQ(said("Area (10³ µm²)"), "area|?");
  EXPECT_EQ(said("Area (Âµm²)"), "area|?");
  EXPECT_EQ(said("Area (?m²)"), "area|?");
  EXPECT_EQ(said("Area (km²)"), "area|2");
  EXPECT_EQ(said("Area (ha2)"), "area|?");
  EXPECT_EQ(said("Area (%)"), "area|?");
  EXPECT_EQ(said("%Area"), "%area|-");
  EXPECT_EQ(said("touches_border"), "touchesborder|-");
  EXPECT_EQ(said("centroid_x"), "centroidx|-");
  EXPECT_EQ(said("(µm²)"), "um2|-");
  EXPECT_EQ(said(""), "|-");
}

struct Loaded {
  Profiles profiles;
  std::vector<std::string> warnings;
};

Loaded loaded(const std::string& text, const std::string& unit = "auto") {
  Loaded out;
  out.profiles = read_profiles(text, "t.csv", profile_unit(unit),
                               [&](const std::string& w) { out.warnings.push_back(w); });
  return out;
}

Diagnostic error_of(const std::string& text, const std::string& unit = "auto") {
  try {
    loaded(text, unit);
  } catch (const Error& e) {
    return e.diagnostic();
  }
  return {};
}

TEST(LoadProfiles, TheUnitOfTheHeaderIsUsed) {
  for (const char* header : {"Area (µm²)", "Area (μm²)", "Area [um^2]", "area_um2", "areaum2", "Area um2",
                             "Area (sq. microns)", "Area (µm)"})
    for (const char* unit : {"auto", "µm", "um2"}) {
      const Loaded l = loaded(std::string(header) + "\n2e6\n", unit);
      EXPECT_NEAR(l.profiles.profiles[0].area, 2, 1e-12) << header;
      EXPECT_TRUE(l.warnings.empty()) << header;
    }
  const double circle = std::numbers::pi / 4;
  EXPECT_NEAR(loaded("Diameter (nm)\n2e6\n").profiles.profiles[0].area, 4 * circle, 1e-12);
  EXPECT_NEAR(loaded("ECD [cm]\n0.2\n").profiles.profiles[0].area, 4 * circle, 1e-12);
  EXPECT_NEAR(
      loaded("Area (cm²),centroid_x (µm),centroid_y (mm)\n1,2000,3\n").profiles.profiles[0].centroid.x(), 2,
      1e-12);
  EXPECT_NEAR(loaded("Area (px),Area (µm²)\n7,2e6\n").profiles.profiles[0].area, 2, 1e-12);
}

// ImageJ writes the unit of lengths, but not of areas, in some settings.
TEST(LoadProfiles, TheUnitOfOtherColumnsIsUsed) {
  const Loaded l = loaded(" ,Area,Feret (µm),Circ.\n1,2e6,3000,0.9\n");
  EXPECT_NEAR(l.profiles.profiles[0].area, 2, 1e-12);
  EXPECT_TRUE(l.warnings.empty());
  EXPECT_EQ(error_of("Area,Feret (µm)\n1,2\n", "mm").code, "contradicting-unit");
  // They disagree, so they say nothing.
  EXPECT_EQ(loaded("Area,Feret (µm),Major (mm)\n2,3,4\n").warnings.size(), 1u);
}

TEST(LoadProfiles, WithoutAnyUnitMillimetersAreAWarning) {
  const Loaded l = loaded("Area,Mean\n2,120\n");
  EXPECT_EQ(l.profiles.profiles[0].area, 2);
  EXPECT_EQ(l.warnings,
            std::vector<std::string>{"'t.csv' names no unit: it is read as Area (mm²); set unit"});
  EXPECT_TRUE(loaded("Area,Mean\n2,120\n", "mm").warnings.empty());
  EXPECT_TRUE(loaded("area,touches_border,confidence\n2,0,1\n").warnings.empty());  // Export writes mm
}

TEST(LoadProfiles, ContradictionsAsk) {
  const Diagnostic d = error_of("Area (µm²)\n2e6\n", "mm");
  EXPECT_EQ(d.code, "contradicting-unit");
  EXPECT_EQ(d.parameter, "unit");
  EXPECT_NE(d.message.find("'Area (µm²)'"), std::string::npos) << d.message;
  EXPECT_NE(d.message.find("unit, which is mm"), std::string::npos) << d.message;
  EXPECT_EQ(error_of("Diameter (µm²)\n2\n").code, "contradicting-unit");
  EXPECT_EQ(error_of("Area (mm³)\n2\n").code, "contradicting-unit");
  for (const char* header : {"Area (px)", "Area (pixels²)", "Area (10³ µm²)", "Area (%)", "Area (?m²)"})
    EXPECT_EQ(error_of(std::string(header) + "\n2\n").code, "unknown-unit") << header;
  EXPECT_EQ(error_of("Slice,Count,%Area\na,3,12\n").code, "no-column");  // a percentage is no area
}

TEST(LoadProfiles, StatisticsAreLeftOutWithAWarning) {
  for (const char* text :
       {" ,Area,Mean\n1,1.5,7\n2,20,8\nMean,10.7,7.5\nSD,9,0.5\nMin,1.5,7\nMax,20,8\n",  // ImageJ
        " \tLabel\tArea\n1\tpic:1\t1.5\n2\tpic:2\t20\n3\tMean\t10.7\n4\tSD\t9\n5\tMin\t1\n6\tMax\t20\n",
        "id;area\n1;1,5\n2;20\nAverage;10,7\nStd. Dev.;9\nMedian:;1\nSum;21,5\n",      // spreadsheets
        "id,area,x\n1,1.5,0\n2,20,0\nCount,2\ntotal,21.5\nMINIMUM,1.5\nmaximum,20\n",  // fewer cells
        ",area\n0,1.5\n1,20\ncount,2\nmean,10\n25%,3\n75%,9\n"}) {                     // pandas
    const Loaded l = loaded(text, "mm");
    ASSERT_EQ(l.profiles.profiles.size(), 2u) << text;
    EXPECT_EQ(l.profiles.profiles[1].area, 20);
    ASSERT_EQ(l.warnings.size(), 1u) << text;
    EXPECT_NE(l.warnings[0].find("4 rows are statistics"), std::string::npos) << l.warnings[0];
    EXPECT_NE(l.warnings[0].find("(line 4)"), std::string::npos) << l.warnings[0];
  }
  EXPECT_EQ(error_of(" ,Area\nMean,2\nSD,1\n").code, "no-particles");
  EXPECT_EQ(error_of("Area\n1\nMean\n").code, "malformed-row");
  // Names that only contain one are those of profiles.
  EXPECT_EQ(loaded("Label,Area\nMaxine,1\nmean grain 3,2\n", "mm").profiles.profiles.size(), 2u);
}

TEST(LoadProfiles, RoundedAreasMayFillTheSection) {
  const auto folder = test::temporary_folder();
  std::ofstream(folder / "a.csv") << "area (mm²)\n1.61500\n1.61499\n";
  const auto run = [&](const char* area) {
    return test::run_node("LoadProfiles", {},
                          {{"path", (folder / "a.csv").string()}, {"observed_area", area}});
  };
  EXPECT_EQ(run("3.22998").output<Profiles>("profiles").area_fraction, 1);
  EXPECT_EQ(run("3.23").output<Profiles>("profiles").area_fraction, 3.22999 / 3.23);
  EXPECT_EQ(test::code_of([&] { run("3.2"); }), "area-too-small");
}

TEST(LoadProfiles, ReadsTheReportedFiles) {
  const auto data = test::shared_data();
  if (data.empty()) GTEST_SKIP() << "no shared data";
  const auto load = [&](const char* name, const std::map<std::string, std::string>& more = {}) {
    std::map<std::string, std::string> parameters = more;
    parameters["path"] = (data / "reports" / name).string();
    return test::run_node("LoadProfiles", {}, parameters);
  };
  const auto micrometers = load("header_um2_one_column.csv");
  const auto& areas = micrometers.output<Profiles>("profiles").profiles;
  EXPECT_EQ(areas.size(), 400u);
  EXPECT_NEAR(areas[0].area, 3.11854662, 1e-9);
  EXPECT_TRUE(micrometers.warnings.empty());
  EXPECT_EQ(test::code_of([&] {
              load("header_um2_one_column.csv", {{"unit", "mm"}});
            }),
            "contradicting-unit");
  const auto summary = load("imagej_summarize.csv", {{"unit", "mm"}});
  EXPECT_EQ(summary.output<Profiles>("profiles").profiles.size(), 400u);
  EXPECT_EQ(summary.warnings.size(), 1u);
  const auto wide = load("utf16.csv", {{"unit", "mm"}});
  EXPECT_EQ(wide.output<Profiles>("profiles").profiles.size(), 400u);
  EXPECT_EQ(wide.output<Profiles>("profiles").profiles[0].area, 3.118547);
}

}  // namespace
}  // namespace terrazzo
