// The trained network: what each pixel of a photograph belongs to.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo::segment {

// What the network says of one section, each from 0 to 1, row by row from the top.
struct NetworkMaps {
  int width = 0, height = 0;
  std::vector<float> inside;        // the pixel lies in a particle
  std::vector<float> border;        // it lies on the inner border of a particle
  std::vector<float> distance;      // distance to the border / the largest one within the same particle
  std::vector<float> not_material;  // ruler, frame, text
};

// A section or a part of it, encoded sRGB from 0 to 1 in three channels.
cv::Mat encoded_section(const Image&, int section);
cv::Mat encoded_window(const Image&, int section, const cv::Rect&);

class Network {
 public:
  // `bytes`: an ONNX model with input (1, 3, h, w), encoded sRGB from 0 to 1, and output (1, 4, h, w) in the
  // order of NetworkMaps, for any h and w that are multiples of 32. Throws Error "bad-model".
  explicit Network(std::string bytes);
  ~Network();
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  // `picture`: see encoded_section(). It is seen at each of the `scales` (1: pixel by pixel), and the maps
  // are enlarged or reduced to its size. At scales from 1 on, maps are the means of those of the picture and
  // of its mirror image. The picture is cut into tiles that depend on its size alone, and each tile is
  // computed by one thread, so the result is the same on any number of threads. Throws Error "bad-model" if
  // the output has another shape.
  std::vector<NetworkMaps> operator()(const cv::Mat& picture, std::span<const double> scales,
                                      const Work&) const;

 private:
  struct Model;
  std::unique_ptr<Model> model_;
};

// The network that comes with the program; nodes/photograph/segment/training describes how it was made.
std::string built_in_model();

}  // namespace terrazzo::segment
