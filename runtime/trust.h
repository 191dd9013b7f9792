// Checks whether other users could change a file or folder that this program trusts.
#pragma once

#include <filesystem>
#include <string>

namespace terrazzo {

// The reason why another user could change the file at `path`, such as "'/tmp/x' belongs to another user" or
// "everybody may write to '/srv/plugins'". "" if only the user and root can. Checks the path and every folder
// above it, with links resolved. `group`: also report write access by a group other than the user's own. If
// the path does not exist, only its existing parent folders are checked.
std::string who_else_may_write(const std::filesystem::path& path, bool group = true);

}  // namespace terrazzo
