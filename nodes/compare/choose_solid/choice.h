// Which of several solids of one photograph is kept.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nodes/data/table.h"

namespace terrazzo::choose_solid {

// From the photograph to a solid.
struct Route {
  std::string name;
  bool reached = false;                   // there is a solid
  std::optional<double> accuracy, error;  // of the observer that recognizes its picture better, in %
};

// The higher accuracy in a table of TextureObserver, with its standard error. Throws Error "no-column" or
// "not-a-number" for another table.
void read_observers(const Table&, Route&);

struct Choice {
  std::size_t route = 0;
  std::string why;  // a sentence
};

// `routes` are in the order of what they keep of the material: phases, particles, colors. Phases are taken if
// there are any, since they are only there for a picture that shows phases. Of the others, the one whose
// picture the observers recognize least; the earlier one if the difference is below two standard errors.
// Throws Error "no-solid" if no route has been reached.
Choice choose(const std::vector<Route>& routes);

// The route of this name. Throws Error "no-solid" if it has not been reached.
Choice take(const std::vector<Route>& routes, const std::string& name);

}  // namespace terrazzo::choose_solid
