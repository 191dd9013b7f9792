// Headers of .ang files as the programs of instruments write them.
#include "nodes/photograph/load_ebsd/ang_header.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace load_ebsd;

const std::string kPhase = "# Phase 1\n# MaterialName  \tNickel\n# Symmetry              43\n";
const std::string kGrid =
    "# GRID: SqrGrid\n# XSTEP: 0.5\n# YSTEP: 0.5\n# NCOLS_ODD: 2\n# NCOLS_EVEN: 2\n# NROWS: 1\n";
const std::string kPoints = "0.1 0.2 0.3 0.0 0.0 90 0.8 0 1 0.5\n1.1 0.2 0.3 0.5 0.0 80 0.7 0 1 0.5\n";

AngHeader header_of(const std::string& text) {
  Lines lines(text, "a.ang");
  return read_ang_header(lines);
}

std::string code(const std::string& text) {
  return test::code_of([&] { read_ang(text, "a.ang"); });
}

TEST(AngHeader, NotesOfTheVendorAreNotRead) {
  const EbsdMap map = read_ang(
      "# HEADER: Start\n" + kPhase + kGrid +
          "# VERSION 7\n# NOTES: Start\n# Phase index: 0 for single phase, starting at 1 for multiphase\n"
          "# XSTEP: none\n# GRID: of anything\n# NOTES: End\n# COLUMN_COUNT: 10\n"
          "# COLUMN_HEADERS: phi1, PHI, phi2, x, y, IQ, CI, Phase index, SEM, Fit\n"
          "# COLUMN_UNITS: radians, radians, radians, microns, microns, , , , , degrees\n"
          "# COLUMN_NOTES: Start\n# Column 1: phi1 [radians]\n# Symmetry 99\n# COLUMN_NOTES: End\n"
          "# HEADER: End\n" +
          kPoints,
      "a.ang");
  EXPECT_EQ(map.width, 2);
  EXPECT_EQ(map.phases.size(), 1u);
  EXPECT_EQ(map.phases[0].name, "Nickel");
  EXPECT_EQ(map.points[1].quality, 80);
  // A note without a block.
  EXPECT_EQ(code(kPhase + "# Phase index: 0 for single phase\n" + kGrid + kPoints), "");
}

TEST(AngHeader, ColumnsAreThoseThatTheHeaderNames) {
  for (const char* names :
       {"# COLUMN_HEADERS: x, y, Phase index, CI, IQ, phi1, PHI, phi2\n",
        "# Column names: x, y, phase_id, confidence_index, image_quality, phi1, Phi, phi2\n"}) {
    const EbsdMap map =
        read_ang(kPhase + kGrid + names + "0.0 0.0 1 0.8 90 0.1 0.2 0.3\n0.5 0.0 1 0.7 80 1 0 0\n", "a.ang");
    EXPECT_EQ(map.points[0].quality, 90) << names;
    EXPECT_FLOAT_EQ(map.points[0].confidence, 0.8f);
    EXPECT_TRUE(map.points[0].orientation.isApprox(from_bunge(0.1, 0.2, 0.3)));
  }
  EXPECT_EQ(code(kPhase + kGrid + "# COLUMN_HEADERS: phi1, PHI, phi2, x, IQ, CI, Phase index\n" + kPoints),
            "malformed-row");
}

TEST(AngHeader, UnitsAreThoseThatTheHeaderNames) {
  const std::string names = "# COLUMN_HEADERS: phi1, PHI, phi2, x, y, IQ, CI, Phase index\n";
  const EbsdMap map = read_ang(kPhase + "# GRID: SqrGrid\n# XSTEP: 500\n# YSTEP: 500\n" + names +
                                   "# COLUMN_UNITS: degrees, degrees, degrees, nm, nm, , , \n"
                                   "57.29578 90 0 0 0 90 0.8 1\n0 0 0 500 0 90 0.8 1\n",
                               "a.ang");
  EXPECT_DOUBLE_EQ(map.pixel_size, 0.5);
  EXPECT_TRUE(map.points[0].orientation.isApprox(from_bunge(1, 1.5707963, 0), 1e-6f));
  EXPECT_EQ(
      code(kPhase + kGrid + names + "# COLUMN_UNITS: gon, gon, gon, microns, microns, , , \n" + kPoints),
      "unreadable-file");
  EXPECT_EQ(code(kPhase + kGrid + names + "# COLUMN_UNITS: radians, radians, radians, microns, nm, , , \n" +
                 kPoints),
            "unreadable-file");
}

// NanoMEGAS ASTAR: no numbers of phases, no steps, nanometers.
TEST(AngHeader, AstarMapsAreInNanometers) {
  const EbsdMap map = read_ang(
      "# File created from ACOM RES results\n# ni-dislocations.res\n#     \n#     \n# MaterialName      "
      "Nickel\n"
      "# Formula\n# Symmetry          43\n# LatticeConstants  3.520  3.520  3.520  90.000  90.000  90.000\n"
      "# NumberFamilies    4\n# hklFamilies       1  1  1 1 0.000000\n#\n# GRID: SqrGrid#\n"
      "4.485496 0.952426 0.791507     0.000     0.000   22.2  0.060  1       6\n"
      "1.343904 0.276111 0.825890    19.000     0.000   16.3  0.020  1       2\n",
      "a.ang");
  EXPECT_EQ(map.width, 2);
  EXPECT_DOUBLE_EQ(map.pixel_size, 0.019);
  EXPECT_EQ(map.phases[0].name, "Nickel");
  EXPECT_EQ(map.phases[0].symmetry.group, LaueGroup::CubicHigh);
}

TEST(AngHeader, GridsHaveSeveralSpellings) {
  for (const char* word : {"SqrGrid", "SqrGrid#", "sqrgrid", "SquareGrid", " SqrGrid "})
    EXPECT_EQ(header_of(kPhase + "# GRID:" + word + "\n").grid.hexagonal, false) << word;
  for (const char* word : {"HexGrid", "HexGrid#", "HEXGRID"})
    EXPECT_EQ(header_of(kPhase + "# GRID: " + word + "\n").grid.hexagonal, true) << word;
  EXPECT_EQ(test::code_of([] { header_of(kPhase + "# GRID: Cubic\n"); }), "malformed-row");
  const AngHeader h = header_of(kPhase + "#XSTEP 0.25\n# YSTEP:0.125\n");
  EXPECT_EQ(h.grid.x_step->value, 0.25);
  EXPECT_EQ(h.grid.y_step->value, 0.125);
}

TEST(AngHeader, OldFilesHaveFewerColumns) {
  EXPECT_EQ(
      read_ang(kPhase + kGrid + "0.1 0.2 0.3 0.0 0.0 90\n1.1 0.2 0.3 0.5 0.0 80\n", "a.ang").points[1].phase,
      0);
  EXPECT_EQ(read_ang(kPhase + kGrid + "0.1 0.2 0.3 0.0 0.0 90 -1\n1.1 0.2 0.3 0.5 0.0 80 0.5\n", "a.ang")
                .points[0]
                .phase,
            -1);
  EXPECT_EQ(code(kPhase + kGrid + "0.1 0.2 0.3 0.0 0.0\n"), "malformed-row");
  EXPECT_EQ(code(kPhase + "# Phase 2\n# Symmetry 62\n" + kGrid + "0.1 0.2 0.3 0.0 0.0 90\n"),
            "malformed-row");
}

TEST(AngHeader, LinesMayEndWithACarriageReturn) {
  std::string text = kPhase + kGrid + kPoints;
  std::replace(text.begin(), text.end(), '\n', '\r');
  EXPECT_EQ(read_ang(text, "a.ang").width, 2);
}

TEST(AngHeader, TheLastDigitOfANumberIsKnown) {
  for (const auto& [text, digit] : {std::pair{"7", 1.0},
                                    {"2.50", 0.01},
                                    {"-0,125", 0.001},
                                    {"1.5e2", 10.0},
                                    {"1.50E-02", 1e-4},
                                    {"2e+1", 10.0}})
    EXPECT_NEAR(last_digit(text) / digit, 1, 1e-9) << text;
}

}  // namespace
}  // namespace terrazzo
