// Figures drawn into an Image: axes, lines, bars, intervals, text. Needs no window system and no font files.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/image.h"

namespace terrazzo {

struct PlotSeries {
  enum class Kind { Line, Points, Bars };
  Kind kind = Kind::Line;
  std::string name;               // in the legend; empty: not listed
  std::vector<double> x, y;       // NaN interrupts a line
  std::vector<double> low, high;  // of y; empty: no intervals
  int color = 0;                  // index into the palette
};

struct Plot {
  std::string title, x_label, y_label;
  bool log_x = false, log_y = false;
  std::vector<std::string> x_words;  // tick labels at x = 0, 1, 2… instead of numbers
  std::vector<PlotSeries> series;
  int width = 720, height = 480;  // pixels
};

Image draw(const Plot&);
// Draws several plots in a grid with `columns` columns.
Image draw(const std::vector<Plot>&, int columns);

// Draws text at a pixel position (top left) with a height in pixels. Supports the characters in
// stroke_font.h. Returns the width.
int draw_text(Image&, int x, int y, const std::string& text, int height, const Vec3f& linear_color);
int text_width(const std::string& text, int height);

}  // namespace terrazzo
