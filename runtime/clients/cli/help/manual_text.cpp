#include "runtime/clients/cli/help/manual_text.h"

#include "runtime/clients/cli/help/roff.h"
#include "runtime/clients/cli/options.h"

namespace terrazzo::cli {
namespace {

std::string entry(const std::string& title, const std::string& text) {
  return roff_entry(roff_bold(title), roff_text(text));
}

std::string example(const std::string& text, const std::string& command) {
  return ".PP\n" + roff_text(text) + "\n.PP\n.nf\n.RS 4\n" + roff_text(command) + "\n.RE\n.fi\n";
}

}  // namespace

std::string manual_description() {
  return ".SH DESCRIPTION\n" +
         roff_text(
             "Terrazzo reconstructs tileable 3D materials from photographs of cut surfaces. It writes glTF, "
             "OpenVDB and images, and reports how well the solid matches the photograph.\n") +
         ".PP\n" +
         roff_text(
             "A graph is a YAML file that connects nodes. The program evaluates nodes in parallel and caches "
             "their results on disk, so an edit recomputes only the nodes that it affects. Names in a graph "
             "have these forms: NODE is a node, ASSET/NODE a node in a subgraph, NODE.PARAM a parameter and "
             "NODE.PORT an output of a node.\n");
}

std::string manual_end() {
  return ".SH EXIT STATUS\n" + entry(std::to_string(kDone), "The command is done.") +
         entry(std::to_string(kNodeFailed),
               "A node failed, a file or the output could not be written, or the cache is damaged.") +
         entry(std::to_string(kWrongUsage), "The graph or the command line is wrong.") +
         entry(std::to_string(kInterrupted), "The command was interrupted. Finished nodes are cached.") +
         ".SH ENVIRONMENT\n" +
         entry("TERRAZZO_PLUGIN_PATH",
               "Plugins to load: a colon-separated list of files and of folders, whose *.so files are all "
               "loaded. Plugins that fail to load are reported and skipped.") +
         entry("OCIO",
               "OpenColorIO configuration for reading images. If it is not set, a built-in configuration is "
               "used.") +
         entry("XDG_CACHE_HOME", "The default cache folder is $XDG_CACHE_HOME/terrazzo.") +
         entry("HOME", "If XDG_CACHE_HOME is not set, the default cache folder is $HOME/.cache/terrazzo.") +
         entry("TMPDIR",
               "If neither is set, the default cache folder is terrazzo-cache-UID in this folder, or in /tmp "
               "if it is not set.") +
         entry("DISPLAY", "If this or WAYLAND_DISPLAY is set, `terrazzo studio` opens a browser.") +
         entry("WAYLAND_DISPLAY", "See DISPLAY.") + ".SH FILES\n" +
         entry("~/.cache/terrazzo", "The default cache folder.") +
         entry("out", "The default folder for output files.") +
         entry("out/report.json",
               "Report of a run that wrote files: status, time and metrics of every node.") +
         entry("/usr/share/terrazzo/graphs",
               "Example graphs. The prefix depends on the installation. Without a graph, `terrazzo run` "
               "evaluates materials/terrazzo.yaml in this folder.") +
         ".SH EXAMPLES\n" + example("Evaluate the default graph and write to ./out:", "terrazzo run") +
         example("Reconstruct a material from a photograph whose pixels are 0.05 mm wide:",
                 "terrazzo run aggregate.yaml --param photo=granite.jpg --param pixel_size=0.05") +
         example("Change the seed of one node. Results that do not depend on it come from the cache:",
                 "terrazzo run terrazzo.yaml --set pack.seed=2") +
         example("Show which nodes would run, and why:", "terrazzo explain terrazzo.yaml") +
         example("Describe the methods of a graph for a paper:", "terrazzo methods terrazzo.yaml") +
         example("Run a graph for every combination of two parameters:",
                 "terrazzo sweep terrazzo.yaml --vary pack.seed=1,2,3 --vary voxels.resolution=64,128") +
         example("Write one output to a file:", "terrazzo show terrazzo.yaml voxels.volume -o solid.vdb") +
         example("Describe a node type:", "terrazzo nodes Anneal") +
         example("Complete commands in the current bash:", "source <(terrazzo completion bash)") +
         ".SH SEE ALSO\n" + roff_bold("dot") + "(1), which draws the output of " +
         roff_bold("terrazzo graph") + ".\n.PP\n" + roff_bold("terrazzo nodes") +
         " lists all node types, and " + roff_bold("terrazzo nodes") + " " + roff_italic("TYPE") +
         " describes one with its inputs, outputs, parameters and source.\n";
}

}  // namespace terrazzo::cli
