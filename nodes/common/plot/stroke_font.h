// A stroke font: every glyph consists of a few polylines, so text needs no font file and scales to any
// height.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo {

// In font units, y up: baseline 0, lower case to 7, capitals to 10, descenders to −3.
struct Glyph {
  double advance = 0;
  std::vector<std::vector<Vec2>> strokes;  // a stroke of one point is a dot
};

constexpr double kFontAscent = 11.0,
                 kFontDescent = 3.4;  // units above and below the baseline in a line of text
constexpr double kFontStroke = 1.15;  // width of the pen, units

// Supports printable ASCII and µ ² ³ ¹ ⁻ ° × · ± – − Δ √ ≤ ≥ π σ φ χ Σ → …; other code points show an empty
// box.
const Glyph& glyph(char32_t code_point);

// Decodes UTF-8; a malformed byte becomes U+FFFD.
std::vector<char32_t> code_points(const std::string& utf8);

}  // namespace terrazzo
