#include "nodes/compare/choose_solid/choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"

namespace terrazzo::choose_solid {
namespace {

constexpr double kCertain = 2;  // standard errors

Error missing(const std::string& what) {
  return Error("no-solid", what, "the messages of the nodes before this one say why");
}

// Whether the pictures of `a` are recognized less than those of `b`, beyond chance.
bool is_closer(const Route& a, const Route& b) {
  if (!a.accuracy || !b.accuracy) return false;
  return *b.accuracy - *a.accuracy > kCertain * std::hypot(*a.error, *b.error);
}

std::string recognized(const Route& r) {
  return r.accuracy
             ? fmt::format("{} ({:.0f} ± {:.0f} % of the crops recognized)", r.name, *r.accuracy, *r.error)
             : r.name;
}

}  // namespace

void read_observers(const Table& t, Route& route) {
  for (std::size_t row = 0; row < t.rows.size(); ++row) {
    const double accuracy = t.number(row, "accuracy %");
    if (route.accuracy && *route.accuracy >= accuracy) continue;
    route.accuracy = accuracy;
    route.error = t.number(row, "standard error %");
  }
}

Choice choose(const std::vector<Route>& routes) {
  std::vector<std::size_t> reached;
  for (std::size_t k = 0; k < routes.size(); ++k)
    if (routes[k].reached) reached.push_back(k);
  if (reached.empty()) throw missing("no route from the photograph to a solid succeeded");
  if (routes[reached[0]].name == "phases")
    return {reached[0], "The photograph shows phases rather than particles."};
  if (reached.size() == 1) return {reached[0], "The other routes gave no solid."};
  std::size_t best = reached[0];
  for (const std::size_t k : reached)
    if (is_closer(routes[k], routes[best])) best = k;
  if (std::any_of(reached.begin(), reached.end(), [&](std::size_t k) { return !routes[k].accuracy; }))
    return {best, fmt::format("The pictures were not compared, and {} keep more of the material.",
                              routes[best].name)};
  const Route& other = routes[best == reached[0] ? reached[1] : reached[0]];
  return {best, best == reached[0]
                    ? fmt::format("No other solid looks more like the photograph than that of {}; {}.",
                                  recognized(routes[best]), recognized(other))
                    : fmt::format("The solid of {} looks more like the photograph than that of {}.",
                                  recognized(routes[best]), recognized(other))};
}

Choice take(const std::vector<Route>& routes, const std::string& name) {
  for (std::size_t k = 0; k < routes.size(); ++k)
    if (routes[k].name == name && routes[k].reached) return {k, "The parameter route asks for it."};
  throw missing(fmt::format("route is '{}', which gave no solid", name)).parameter("route");
}

}  // namespace terrazzo::choose_solid
