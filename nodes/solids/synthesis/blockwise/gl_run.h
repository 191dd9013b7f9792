// The state of the passes over one region on the device.
#pragma once

#include <vector>

#include "nodes/solids/synthesis/blockwise/gl_buffers.h"

namespace terrazzo::solids {

// The passes over one region, whose arrays are on the device while this lives.
class BlockGl::Run {
 public:
  Run(Gl&, const BlockPasses&, BlockProbe*, BlockRegion&, const Work&);

  void run(bool to_blend, const BlockFinish*);

 private:
  // Waits for the device, so that the note tells what it does.
  void stage(double done, const char* note) const {
    gl_.Finish();
    work_.progress(done, note);
  }
  void upload_exemplars();
  void upload_matches();
  void download_field();
  void download_weights();
  void download_matches();

  // Blend `i` and the map of values after it.
  void blend(std::size_t i, const Work&);
  void blend_patches(std::size_t i, const Vec3i& first, const Vec3i& last, const Work&);
  // Applies a map to a channel's values in a range, and updates their copies.
  void map_values(std::size_t channel, const Remap&, const Vec3i& first, const Vec3i& last);
  // Starts a program that places a channel's values in the map's bins.
  void use_values(unsigned program, std::size_t channel, const Remap&);
  // The map of a channel's values in a box to the wanted ones.
  ValueMap measured_values(std::size_t channel, const TorusBox&, const Quantiles& wanted);
  // The counts of `maps` histograms that a program counted.
  std::vector<Remap::Counts> counted(std::size_t maps);
  void finish(const BlockFinish&, const Work&);
  void finish_round(const BlockFinish&, std::size_t channel, const TorusBox&, FinishMaps&);
  // Prepares the program for the bands of a channel across a family's axis, and runs it over a box.
  void split_bands(const NeighborField&, std::size_t channel, const std::vector<Remap>&, bool counting,
                   const TorusBox&);
  // The search of iteration `i` in the slices of family `k`.
  void search(std::size_t i, std::size_t k, const Work&);
  void set_exemplar(const NeighborField&);
  void set_random_numbers(std::size_t i, const NeighborField&);
  // Turns squared distances into weights.
  void weigh(std::size_t i, std::size_t k);
  // Copies what lies beyond one period of closed lines from its originals.
  void copy_beyond(const GlBuffer& what, std::size_t first, const Vec3i& size, const Vec3i& at);

  // The patches of a family over a box: columns, rows and slices.
  struct PatchBox {
    Vec3i first, last;
  };
  PatchBox patches_over(const TorusBox&, const NeighborField&) const;

  Gl& gl_;
  const BlockPasses& passes_;
  BlockProbe* probe_;
  BlockRegion& region_;
  const Work& work_;
  const TorusLines& lines_;
  std::size_t channels_, voxels_;
  LineTables tables_;
  GlBuffer field_, matches_, next_, weight_, numbers_, texels_, maps_, table_, counts_, sum_;
  std::vector<ExemplarBuffers> exemplars_;
  std::vector<int> first_texel_;          // of each exemplar
  std::vector<std::size_t> first_match_;  // of each family
};

}  // namespace terrazzo::solids
