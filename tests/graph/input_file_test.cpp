// Only regular files are read, whatever a name leads to, and none is read before its size is known.
#include "graph/input_file.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <fstream>

#include "graph/document/raw_document.h"
#include "graph/graph.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

class FilesToRead : public ::testing::Test {
 protected:
  fs::path pipe() {
    const fs::path path = folder / "pipe.yaml";
    EXPECT_EQ(::mkfifo(path.c_str(), 0600), 0);
    return path;
  }
  fs::path sparse() {
    const fs::path path = folder / "sparse.yaml";
    std::ofstream(path).flush();
    fs::resize_file(path, std::uintmax_t{200} << 30);
    return path;
  }
  fs::path socket() {
    const fs::path path = folder / "s";
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    const int s = ::socket(AF_UNIX, SOCK_STREAM, 0);
    EXPECT_EQ(::bind(s, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::close(s);
    return path;
  }
  const fs::path folder = test::temporary_folder();
};

TEST_F(FilesToRead, WhatIsNoRegularFileIsRefusedAtOnce) {
  EXPECT_EQ(InputFile(folder).trouble(), "it is a folder");
  EXPECT_NE(InputFile(pipe()).trouble().find("pipe"), std::string::npos);
  EXPECT_NE(InputFile(socket()).trouble().find("socket"), std::string::npos);
  EXPECT_NE(InputFile("/dev/zero").trouble().find("device"), std::string::npos);
  EXPECT_NE(InputFile("/proc/self/status").trouble().find("no size"), std::string::npos);
  EXPECT_EQ(InputFile(folder / "none").trouble(), "No such file or directory");
  for (const fs::path& path : {folder, folder / "pipe.yaml", folder / "s", fs::path("/dev/zero")}) {
    EXPECT_FALSE(read_input_file(path, 100)) << path;
    EXPECT_EQ(read_beginning(path, 100), "") << path;
  }
}

TEST_F(FilesToRead, TheSizeIsCheckedBeforeAnythingIsRead) {
  const FileText text = read_input_file(sparse(), 1000);
  EXPECT_FALSE(text);
  EXPECT_TRUE(text.too_large);
  EXPECT_EQ(text.trouble, "it has 214748364800 bytes, and at most 1000 are read");
  EXPECT_EQ(read_beginning(folder / "sparse.yaml", 3), std::string(3, '\0'));
}

TEST_F(FilesToRead, RegularFilesAreReadWhole) {
  std::ofstream(folder / "a") << "content";
  std::ofstream(folder / "empty").flush();
  EXPECT_EQ(read_input_file(folder / "a", 7).text, "content");
  EXPECT_TRUE(read_input_file(folder / "a", 6).too_large);
  EXPECT_TRUE(read_input_file(folder / "empty", 0));
  EXPECT_EQ(read_beginning(folder / "a", 3), "con");
  EXPECT_EQ(read_beginning(folder / "a", 30), "content");
}

TEST_F(FilesToRead, GraphsAndSubgraphsAreRegularFiles) {
  Diagnostics found;
  load_graph(pipe(), test::arithmetic(), {}, found);
  load_graph(sparse(), test::arithmetic(), {}, found);
  load_graph("/dev/zero", test::arithmetic(), {}, found);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_NE(found[0].message.find("pipe"), std::string::npos) << found[0].message;
  EXPECT_EQ(found[1].code, "too-large");
  EXPECT_NE(found[2].message.find("device"), std::string::npos) << found[2].message;
  for (const char* inner : {"pipe.yaml", "sparse.yaml"}) {
    found.clear();
    load_graph_text("terrazzo: 1\nnodes:\n  a: {graph: " + std::string(inner) + "}\n", folder / "g.yaml",
                    test::arithmetic(), {}, found);
    ASSERT_FALSE(found.empty()) << inner;
    EXPECT_EQ(found[0].place.line, 3) << inner;
  }
}

// Code that reads YAML recursively needs a limit.
TEST(DeepYaml, IsAnErrorAndNoCrash) {
  const std::size_t deep = 300'000;
  std::string block;
  for (int k = 0; k < 2000; ++k) block += std::string(static_cast<std::size_t>(k), ' ') + "a:\n";
  for (const std::string& value : {std::string(deep, '['), std::string(deep, '{'),
                                   "[" + std::string(600, '[') + std::string(601, ']')}) {
    Diagnostics found;
    read_document("terrazzo: 1\nnodes: " + value + "\n", "g.yaml", found);
    ASSERT_TRUE(has_errors(found)) << value.size();
    EXPECT_NE(found[0].message.find("nested more than"), std::string::npos) << found[0].message;
    try {
      read_written(value);
      ADD_FAILURE() << value.size();
    } catch (const Error& e) {
      EXPECT_LT(e.diagnostic().message.size(), 300u);
    }
  }
  Diagnostics found;
  read_document("terrazzo: 1\nnodes:\n" + block, "g.yaml", found);
  EXPECT_TRUE(has_errors(found));
}

}  // namespace
}  // namespace terrazzo
