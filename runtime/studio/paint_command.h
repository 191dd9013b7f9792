// terrazzo paint IMAGE
#pragma once

namespace CLI {
class App;
}

namespace terrazzo::studio {

void add_paint(CLI::App&, int& exit_code);

}  // namespace terrazzo::studio
