// The contact sheet of a sweep.
#pragma once

#include <vector>

#include "runtime/clients/cli/options.h"
#include "runtime/sweep/sweep.h"

namespace terrazzo::cli {

// Writes sweep.png, a contact sheet of the previews of the given points (from 0), with the nodes LoadImage
// and ContactSheet. `preview`: the name of the file that each of these points wrote.
void write_sweep_sheet(const Program&, Session&, const GraphOptions&, const std::string& preview,
                       const SweepPoints&, const std::vector<std::size_t>& with_preview);

}  // namespace terrazzo::cli
