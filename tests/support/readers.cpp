#include "tests/support/readers.h"

#include <gtest/gtest.h>

namespace terrazzo::test {
namespace {

nlohmann::json printed_json(const std::vector<std::string>& command) {
  const ProgramRun run = run_command(command);
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  auto json = nlohmann::json::parse(run.out, nullptr, false);
  EXPECT_FALSE(json.is_discarded()) << run.out << run.err;
  return json;
}

}  // namespace

bool has_program(const std::string& name) {
  return run_command({"/bin/sh", "-c", "command -v " + name}).exit_code == 0;
}

std::string chromium() {
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"})
    if (const auto r = run_command({"sh", "-c", std::string("command -v ") + name}); r.exit_code == 0)
      return r.out.substr(0, r.out.find('\n'));
  return {};
}

bool has_python_module(const std::string& name) {
  return run_command({"/usr/bin/python3", "-c", "import " + name}).exit_code == 0;
}

std::filesystem::path npm_check(const std::string& name) {
  namespace fs = std::filesystem;
  if (!has_program("node") || !has_program("npm")) return {};
  const fs::path source = source_folder() / "tests/integration" / name;
  const fs::path folder = fs::temp_directory_path() / ("terrazzo-" + name);
  std::error_code error;
  fs::create_directories(folder, error);
  for (const auto& file : fs::directory_iterator(source))
    fs::copy_file(file, folder / file.path().filename(), fs::copy_options::overwrite_existing, error);
  const std::string in = "cd '" + folder.string() + "' && ";
  const auto succeeds = [&](const std::string& command) {
    return run_command({"/bin/sh", "-c", in + command}).exit_code == 0;
  };
  if (!succeeds("npm ls") && !succeeds("timeout 120 npm install --no-audit --no-fund --no-package-lock"))
    return {};
  return folder;
}

nlohmann::json run_npm_check(const std::filesystem::path& folder, const std::filesystem::path& file) {
  return printed_json({"node", (folder / "check.mjs").string(), file.string()});
}

nlohmann::json run_reader(const std::string& script, const std::vector<std::string>& arguments) {
  std::vector<std::string> command = {"/usr/bin/python3",
                                      (source_folder() / "tests/integration/readers" / script).string()};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return printed_json(command);
}

}  // namespace terrazzo::test
