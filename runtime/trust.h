// Whether somebody else could change a file or folder that this program believes.
#pragma once

#include <filesystem>
#include <string>

namespace terrazzo {

// Why another user could change what lies at `path`, such as "'/tmp/x' belongs to another user" or "everybody
// may write to '/srv/plugins'"; "" if nobody but the user and root can. Looks at the path and every folder
// above it, links resolved. `group`: also object if a group other than the user's own may write. A path that
// does not exist is judged by the folders that do.
std::string who_else_may_write(const std::filesystem::path& path, bool group = true);

}  // namespace terrazzo
