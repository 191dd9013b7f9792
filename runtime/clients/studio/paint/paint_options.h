// Options of the command `terrazzo paint IMAGE`.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace terrazzo::studio {

struct PaintOptions {
  std::string image, save;
  bool overwrite = false;
  int port = 0;
};

void add_paint(CLI::App&, int& exit_code);

}  // namespace terrazzo::studio
