// Belongs to the program itself, which prints its help without loading the studio.
#include "runtime/studio/paint_options.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "runtime/studio/library.h"

namespace terrazzo::studio {

void add_paint(CLI::App& app, int& exit_code) {
  auto* command =
      app.add_subcommand("paint", "Paint on a picture with texture nibs, in a browser on this machine");
  auto o = std::make_shared<PaintOptions>();
  command->add_option("image", o->image, "Picture to paint on")->required();
  command->add_option(
      "--save", o->save,
      "Graph file that the page saves to (default: IMAGE's name with _painted.yaml, here, numbered "
      "if that exists)");
  command->add_flag("--overwrite", o->overwrite, "Let the page replace the file that --save names")
      ->needs("--save");
  command->add_option("--port", o->port, "Port on 127.0.0.1; 0: any that is free")
      ->check(CLI::Range(0, 65535));
  command->callback([o, &exit_code] { exit_code = library().paint(*o); });
}

}  // namespace terrazzo::studio
