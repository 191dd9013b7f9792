// The exact K matrix of spheres.
#pragma once

#include "nodes/data/shapes.h"
#include "nodes/sizes/kmatrix/make_kmatrix.h"
#include "tests/support/run_node.h"

namespace terrazzo::test {

template <int classes>
const KMatrix& spheres() {
  static const KMatrix k = [] {
    const auto ball = run_node("Shape", {}, {{"kind", "sphere"}, {"size", "1"}}).outputs.at("shapes");
    return kmatrix::make_kmatrix(ball.as<Shapes>(),
                                 {.method = kmatrix::Method::Analytic, .classes = classes});
  }();
  return k;
}

}  // namespace terrazzo::test
