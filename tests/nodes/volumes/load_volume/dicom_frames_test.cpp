// DICOM files with many frames, written by DCMTK itself.
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "nodes/data/volume.h"
#include "nodes/volumes/load_volume/scan.h"
#include "runtime/files.h"
#include "tests/nodes/volumes/load_volume/load.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

struct FrameFile {
  std::vector<Vec3> places;                    // of each frame; none: no functional groups
  std::string direction = "1\\0\\0\\0\\1\\0";  // shared by all frames
  std::vector<int> turned;                     // frames with a direction of their own
  std::optional<double> between;               // in the data set
  bool preamble = true;
  int frames() const { return static_cast<int>(places.size()); }
};

void put(DcmItem& item, const DcmTagKey& tag, const std::string& v) {
  ASSERT_TRUE(item.putAndInsertString(tag, v.c_str()).good()) << v;
}

DcmItem& group(DcmItem& set, const DcmTagKey& groups, int frame, const DcmTagKey& kind) {
  DcmItem *all = nullptr, *one = nullptr;
  set.findOrCreateSequenceItem(groups, all, frame);
  all->findOrCreateSequenceItem(kind, one, 0);
  return *one;
}

// Frame k of 3 × 2 pixels has the values 100 k + 10 row + column.
void write_frames(const fs::path& path, const FrameFile& f, int frames) {
  DcmFileFormat file;
  DcmDataset& set = *file.getDataset();
  put(set, DCM_SOPClassUID, UID_EnhancedCTImageStorage);
  put(set, DCM_SOPInstanceUID, "1.2.3.4");
  put(set, DCM_SeriesInstanceUID, "1.2.3");
  put(set, DCM_PhotometricInterpretation, "MONOCHROME2");
  put(set, DCM_NumberOfFrames, std::to_string(frames));
  for (const auto& [tag, v] :
       {std::pair(DCM_SamplesPerPixel, 1), std::pair(DCM_Rows, 2), std::pair(DCM_Columns, 3),
        std::pair(DCM_BitsAllocated, 16), std::pair(DCM_BitsStored, 16), std::pair(DCM_HighBit, 15),
        std::pair(DCM_PixelRepresentation, 1)})
    set.putAndInsertUint16(tag, static_cast<Uint16>(v));
  const auto place = [](const Vec3& p) { return fmt::format("{}\\{}\\{}", p.x(), p.y(), p.z()); };
  if (f.places.empty()) {
    put(set, DCM_PixelSpacing, "0.5\\0.5");
    put(set, DCM_ImagePositionPatient, "0\\0\\0");
    put(set, DCM_ImageOrientationPatient, f.direction);
  } else {
    DcmItem& shared = group(set, DCM_SharedFunctionalGroupsSequence, 0, DCM_PlaneOrientationSequence);
    put(shared, DCM_ImageOrientationPatient, f.direction);
    DcmItem& measures = group(set, DCM_SharedFunctionalGroupsSequence, 0, DCM_PixelMeasuresSequence);
    put(measures, DCM_PixelSpacing, "0.5\\0.5");
    for (int k = 0; k < f.frames(); ++k)
      put(group(set, DCM_PerFrameFunctionalGroupsSequence, k, DCM_PlanePositionSequence),
          DCM_ImagePositionPatient, place(f.places[static_cast<std::size_t>(k)]));
    for (const int k : f.turned)
      put(group(set, DCM_PerFrameFunctionalGroupsSequence, k, DCM_PlaneOrientationSequence),
          DCM_ImageOrientationPatient, "1\\0\\0\\0\\0\\1");
  }
  if (f.between) put(set, DCM_SpacingBetweenSlices, fmt::format("{}", *f.between));
  put(set, DCM_SliceThickness, "7");
  std::vector<Uint16> values;
  for (int k = 0; k < frames; ++k)
    for (int i = 0; i < 6; ++i) values.push_back(static_cast<Uint16>(100 * k + 10 * (i / 3) + i % 3));
  set.putAndInsertUint16Array(DCM_PixelData, values.data(), values.size());
  ASSERT_TRUE(file.saveFile(path.c_str(), EXS_LittleEndianExplicit, EET_UndefinedLength, EGL_recalcGL,
                            EPD_noChange, 0, 0, f.preamble ? EWM_fileformat : EWM_dataset)
                  .good());
}

test::NodeRun loaded(const FrameFile& f, int frames = 0) {
  const auto folder = test::temporary_folder();
  write_frames(folder / "a.dcm", f, frames > 0 ? frames : f.frames());
  return test::load_volume(folder / "a.dcm");
}

std::string code(const FrameFile& f, int frames = 0) {
  return test::code_of([&] { loaded(f, frames); });
}

openvdb::FloatGrid::ConstPtr frames_grid(const test::NodeRun& run) {
  return run.output<Volume>("volume").find<openvdb::FloatGrid>("density");
}
// The frame that plane z is made from.
int frame_at(const test::NodeRun& run, int z) {
  return static_cast<int>(frames_grid(run)->tree().getValue(openvdb::Coord(2, 1, z))) / 100;
}

TEST(DicomFrames, AreOrderedByPosition) {
  const FrameFile f{.places = {{0, 0, 6}, {0, 0, 2}, {0, 0, 8}, {0, 0, 4}}, .between = 99};
  const auto run = loaded(f);
  for (int z = 0; z < 4; ++z)
    EXPECT_EQ(frame_at(run, z), (std::array{1, 3, 0, 2})[static_cast<std::size_t>(z)]);
  EXPECT_TRUE(frames_grid(run)->voxelSize().eq(openvdb::Vec3d(0.5, 0.5, 2), 1e-9))
      << frames_grid(run)->voxelSize();
  // The patient's left and back are −x and −y.
  EXPECT_EQ(frames_grid(run)->tree().getValue(openvdb::Coord(2, 1, 0)), 100);
  EXPECT_EQ(frames_grid(run)->tree().getValue(openvdb::Coord(0, 0, 0)), 112);
}

TEST(DicomFrames, FollowTheNormalOfObliquePlanes) {
  // Rows to the left, columns down: the normal points to the back, so frames further in front are later here.
  FrameFile f{.places = {{0, -4, 0}, {0, 0, 0}, {0, -2, 0}}, .direction = "1\\0\\0\\0\\0\\-1"};
  const auto run = loaded(f);
  const auto at = [&](int y) {
    return static_cast<int>(frames_grid(run)->tree().getValue(openvdb::Coord(2, y, 1))) / 100;
  };
  EXPECT_EQ(at(0), 1);  // the back
  EXPECT_EQ(at(1), 2);
  EXPECT_EQ(at(2), 0);
  // 30 degrees about x: positions differ in y and z, but not along the columns.
  const double c = 0.8660254037844387, s = 0.5;
  f.direction = fmt::format("1\\0\\0\\0\\{}\\{}", c, s);
  for (int k = 0; k < 3; ++k) f.places[static_cast<std::size_t>(k)] = 3.0 * (2 - k) * Vec3(0, -s, c);
  const auto tilted = loaded(f);
  EXPECT_EQ(frame_at(tilted, 0), 2);
  EXPECT_EQ(frame_at(tilted, 2), 0);
  EXPECT_NEAR(frames_grid(tilted)->voxelSize()[2], 3, 1e-6);
  EXPECT_EQ(tilted.warnings.size(), 2u);  // the tilt, and no rescale
}

TEST(DicomFrames, GapsAndMissingPlacesAreErrors) {
  EXPECT_EQ(code({.places = {{0, 0, 0}, {0, 0, 2}, {0, 0, 4}, {0, 0, 6}, {0, 0, 16}, {0, 0, 18}}}),
            "missing-slices");
  EXPECT_EQ(code({.places = {{0, 0, 0}, {0, 0, 2}, {0, 0, 4}, {0, 0, 6.5}}}), "missing-slices");
  EXPECT_EQ(code({.places = {{0, 0, 0}, {0, 0, 2}, {0, 0, 2}}}), "missing-slices");
  EXPECT_EQ(code({.places = {{0, 0, 0}, {0, 0, 2}}, .turned = {1}}), "mixed-series");
  EXPECT_EQ(code({.places = {{0, 0, 0}, {0, 3, 2}}}), "tilted-volume");
  EXPECT_EQ(code({.places = {{0, 0, 0}, {0, 0, 2}}}, 3), "unreadable-volume")
      << "a frame without a description";
  EXPECT_EQ(code({}, 3), "missing-slices") << "the thickness is not the spacing";
}

TEST(DicomFrames, TheSignOfTheSpacingIsTheDirectionOfTheStack) {
  for (const double between : {2.0, -2.0}) {
    const auto run = loaded({.between = between}, 3);
    EXPECT_EQ(frame_at(run, 0), between > 0 ? 0 : 2);
    EXPECT_EQ(frames_grid(run)->voxelSize()[2], 2);
  }
}

TEST(DicomFrames, FilesWithoutAPreambleAreRead) {
  const auto run = loaded({.places = {{0, 0, 2}, {0, 0, 0}}, .preamble = false});
  EXPECT_EQ(frame_at(run, 0), 1);
}

TEST(DicomFrames, TheSharedFiles) {
  const fs::path folder = test::shared_data() / "reports";
  if (!fs::exists(folder / "enh_gap.dcm")) GTEST_SKIP() << "no shared data";
  const auto run = test::load_volume(folder / "enh_descending.dcm");
  const auto g = frames_grid(run);
  for (int z = 0; z < run.output<Volume>("volume").extent.z(); ++z)
    EXPECT_NEAR(g->tree().getValue(openvdb::Coord(0, 0, z)), 20 * z - 1000, 1e-3);
  EXPECT_EQ(test::code_of([&] { test::load_volume(folder / "enh_gap.dcm"); }), "missing-slices");
}

}  // namespace
}  // namespace terrazzo
