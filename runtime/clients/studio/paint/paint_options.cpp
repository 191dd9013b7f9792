// Part of the program itself, so that help does not load the studio library.
#include "runtime/clients/studio/paint/paint_options.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "runtime/clients/cli/placeholders.h"
#include "runtime/clients/studio/library.h"

namespace terrazzo::studio {
namespace placeholder = cli::placeholder;

void add_paint(CLI::App& app, int& exit_code) {
  auto* command =
      app.add_subcommand("paint", "Paint on an image with texture nibs, in a browser on this machine");
  auto o = std::make_shared<PaintOptions>();
  command->add_option("image", o->image, "Image to paint on")->type_name(placeholder::image)->required();
  command
      ->add_option("--save", o->save,
                   "Graph file to save to (default: IMAGE's name with _painted.yaml, in the current folder, "
                   "numbered if it exists)")
      ->type_name(placeholder::file);
  command->add_flag("--overwrite", o->overwrite, "Allow replacing an existing --save file")->needs("--save");
  command->add_option("--port", o->port, "Port on 127.0.0.1; 0: any free port")
      ->type_name(placeholder::number)
      ->check(CLI::Range(0, 65535));
  command->callback([o, &exit_code] { exit_code = library().paint(*o); });
}

}  // namespace terrazzo::studio
