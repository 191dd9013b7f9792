// One function for each file format, or for formats that are written alike.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>

#include "nodes/data/georeference.h"
#include "nodes/data/labels.h"
#include "nodes/data/particles.h"
#include "nodes/data/profiles.h"
#include "nodes/data/volume.h"
#include "nodes/export/formats.h"
#include "nodes/export/formats/material_maps.h"
#include "nodes/export/outputs.h"
#include "runtime/context.h"

namespace terrazzo::exporting {

// The inputs of Export, named after their types.
struct Input {
  const char *name, *type, *doc;
};
inline constexpr std::array<Input, 10> kInputs = {{
    {"image", "Image",
     "Image or stack of images. In a .glb file, the texture of the shapes. Beside profiles or labels, their "
     "picture"},
    {"labels", "Labels", "Profile id of each pixel. Beside profiles, these tell the size of a pixel"},
    {"profiles", "Profiles", "Profiles of plane sections"},
    {"shapes", "Shapes", "Shapes of the particles"},
    {"kmatrix", "KMatrix", "K matrix, the probabilities of profile sizes"},
    {"distribution", "SizeDistribution", "Number of particles per volume by size"},
    {"particles", "Particles",
     "Packing. A .glb, .usda, .xml, .pbrt or .lmp file also needs shapes. A .vti or .inp file takes classes, "
     "voids and orientations from it"},
    {"volume", "Volume", "Volume of named grids"},
    {"table", "Table",
     "Table of named columns. In a .vti, .inp, .dream3d, .tesr or .lmp file, the materials: one row per "
     "phase"},
    {"strokes", "Strokes", "Strokes on an image"},
}};

// Of the picture that is connected beside its profiles; zeros if none is.
struct PictureSize {
  int width = 0, height = 0, sections = 1;  // pixels
  double pixel_size = 0;                    // mm
  std::optional<Georeference> georeference = {};
};

// What one Export node is to write. `values` fit the format: check_fit() was called.
struct Job {
  Context& context;
  std::string path;  // below the output folder
  const Format& format;
  std::map<std::string, Value> values;  // by type name, and texture maps by the name of their input

  // Null if no value of this type is connected.
  template <class T>
  const T* find(const char* type) const {
    const auto it = values.find(type);
    return it == values.end() ? nullptr : &it->second.as<T>();
  }
  const Particles* particles() const { return find<Particles>("Particles"); }
  const Volume* volume() const { return find<Volume>("Volume"); }
  MaterialMaps maps() const;
  // Throws Error "size-mismatch" if it is not theirs.
  PictureSize picture(const Profiles&) const;
  std::optional<Georeference> place_of(const Labels&) const;
  const Value& only() const { return values.begin()->second; }  // of formats that hold one value
};

// Each throws the errors of its writer.
void write_csv_file(const Job&);
void write_glb_file(const Job&);  // also "no-uv"
void write_json_file(const Job&);
void write_lammps_file(const Job&);
void write_materialx_file(const Job&);  // also the maps beside it
void write_mesh_file(const Job&);       // of shapes or a packing: .obj, .ply, .stl
void write_nifti_file(const Job&);      // .nii, .nii.gz
void write_npy_file(const Job&);
void write_nvdb_file(const Job&);
void write_outlines(const Job&);       // .geojson, .coco.json, .roi, .zip; also "missing-input"
void write_pictures(const Job&);       // .png, .tif, .exr, .jpg, .hdr; one file per section
void write_solid_texture(const Job&);  // of a volume: .dds, .ktx2 and, as slices, .png
void write_scene(const Job&);          // .usda, .xml (Mitsuba), .pbrt
void write_stl_file(const Job&);       // of shapes, a packing or a volume; also "format-does-not-fit"
void write_surfaces(const Job&);       // .msh and .stl of a volume; also "missing-input"
void write_vdb_file(const Job&);
// .vti, .vtu, .dream3d, .inp, .tesr, .foam
template <void (*write)(Context&, const VoxelJob&)>
void write_voxels(const Job& job) {
  write(job.context, {job.path, job.format, *job.volume(), job.particles(), job.find<Table>("Table")});
}

}  // namespace terrazzo::exporting
