// An unfolding as a table and a figure.
#pragma once

#include "nodes/data/image.h"
#include "nodes/data/table.h"
#include "nodes/unfold/unfold.h"

namespace terrazzo {

// One row per colour class and size class; where nothing is visible, profile columns hold "not visible".
Table unfold_table(const Unfolding&);

// Per colour class: N_A as observed with the refit, beside N_V with its intervals. All classes of the first
// six colour classes.
Image unfold_figure(const Unfolding&);

}  // namespace terrazzo
