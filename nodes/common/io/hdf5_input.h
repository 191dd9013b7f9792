// Reader of HDF5 files in the form that the library writes by default (superblock 0, version 1 of object
// headers and groups), which DREAM3D, h5py and MATLAB use. Written for Terrazzo, because the library trusts
// its input.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace terrazzo {

enum class Hdf5Kind {
  Signed,
  Unsigned,
  Float,
  Text,
  Other
};  // Text: of fixed length. Other: all other types

// Numbers or texts in a block of 0 or more axes, the last fastest.
struct Hdf5Array {
  Hdf5Kind kind = Hdf5Kind::Other;
  std::size_t bytes = 0;            // of an element
  std::vector<std::uint64_t> size;  // elements along each axis; empty for a single one
  std::uint64_t count() const;      // elements
};

// All addresses and lengths are checked against the content. Every function throws Error "unreadable-volume"
// if the file is damaged or of another form.
class Hdf5Input {
 public:
  using Address = std::uint64_t;

  explicit Hdf5Input(const std::string& content);  // keeps a reference
  static bool is_hdf5(const std::string& beginning);

  Address root() const { return root_; }
  bool is_group(Address) const;
  std::map<std::string, Address> children(Address group) const;
  // The object at a path such as "/a/b", or 0 if there is none.
  Address find(const std::string& path) const;

  // What a dataset contains. Throws also if its data are stored in a way that `read` does not support.
  Hdf5Array array(Address dataset) const;
  // Its elements, little-endian. Bytes that were never written are 0. The caller checks the memory before.
  std::string read(Address dataset) const;
  // Elements of an attribute; false if there is none.
  bool attribute(Address object, const std::string& name, Hdf5Array&, std::string& bytes) const;

 private:
  struct Message {
    unsigned type;
    std::uint64_t at, size;
  };
  struct Layout;
  std::uint64_t number(std::uint64_t at, unsigned bytes) const;
  void require(std::uint64_t at, std::uint64_t bytes) const;
  void require_text(std::uint64_t at, const char* expected) const;
  std::vector<Message> messages(Address object) const;
  void read_type(const Message&, Hdf5Array&) const;
  void read_space(const Message&, Hdf5Array&) const;
  Layout layout(Address dataset) const;
  void visit_links(std::uint64_t tree, std::uint64_t names, std::uint64_t names_size, unsigned deepest,
                   std::map<std::string, Address>&) const;
  void visit_chunks(std::uint64_t node, unsigned deepest, const Layout&, std::string& out) const;
  void place_chunk(std::uint64_t key, std::uint64_t data, const Layout&, std::string& out) const;

  const std::string& content_;
  Address root_ = 0;
  mutable std::uint64_t nodes_left_ = 0;   // of trees, which may not have loops
  mutable std::uint64_t chunks_left_ = 0;  // each part of a dataset is stored once
};

}  // namespace terrazzo
