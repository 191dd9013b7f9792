// Marks at equal distances along a line, as rulers have.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace terrazzo::segment {

// A picture turned so that lines at `angle` (radians, clockwise from the x axis, y down) lie in its rows.
struct TurnedFrame {
  double angle = 0;
  cv::Matx23d to_frame, to_picture;
  cv::Size size;

  TurnedFrame(const cv::Size& picture, double angle);
  cv::Mat turned(const cv::Mat& picture) const;  // black outside
  cv::Point2d in_picture(double x, double y) const;
  cv::Point2d in_frame(const cv::Point2d& of_picture) const;
};

// Marks that cross a band of rows of a turned picture.
struct Comb {
  double angle = 0;
  int left = 0, right = 0, top = 0, bottom = 0;  // pixels of the turned picture, right and bottom excluded
  double step = 0;                               // distance of neighboring marks, in pixels
  int marks = 0;                                 // at least 10 marks, or 9 edges of blocks
  int rows = 0;                                  // of the turned picture that show them
  double weight() const { return static_cast<double>(marks) * rows; }
};

// Bands in which at least three of every second row show the same marks: at least ten that become
// lighter in the same direction, or nine edges of blocks that become lighter and darker in turn, at distances
// that agree within 6 %, between two lightnesses that repeat.
std::vector<Comb> find_combs(const cv::Mat& gray, double angle);

}  // namespace terrazzo::segment
