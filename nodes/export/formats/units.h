// Units of files in SI.
#pragma once

namespace terrazzo::exporting {

inline constexpr double kMetersPerMm = 0.001;

}  // namespace terrazzo::exporting
