// Reader of HDF5 files: the form that the library writes by default (superblock 0, version 1 of object
// headers and groups), which DREAM3D, h5py and MATLAB use, and the newer one (superblock 2 and 3,
// libver='latest'). Written for Terrazzo, because the library trusts its input.
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
  bool big_endian = false;          // in the file
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
  // Elements of an attribute, little-endian; false if there is none.
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
  Address root_of_superblock() const;
  std::vector<Message> messages(Address object) const;
  std::vector<Message> messages_1(Address object) const;
  std::vector<Message> messages_2(Address object) const;
  static void add_message(const Message&, std::uint64_t flags, std::vector<Message>&);
  void add_link(const Message&, std::map<std::string, Address>&) const;
  struct HeapTable;
  HeapTable heap_table(Address heap) const;
  std::uint64_t heap_place(const HeapTable&, std::uint64_t offset) const;
  // The links (`type` 5) or attributes (8) that a tree of version 2 names in a heap.
  std::vector<Message> heap_objects(Address heap, Address tree, unsigned type) const;
  std::vector<Message> attributes(Address object) const;
  struct Records {
    std::uint64_t size = 0;
    std::vector<std::uint64_t> at;
  };
  // Of a tree of version 2.
  Records records(Address tree) const;
  void read_type(const Message&, Hdf5Array&) const;
  static void turn_bytes(const Hdf5Array&, std::string& elements);
  void read_space(const Message&, Hdf5Array&, std::vector<std::uint64_t>* most = nullptr) const;
  Layout layout(Address dataset) const;
  void read_filters(const Message&, Layout&) const;
  void read_layout(const Message&, Layout&) const;
  void read_chunk_layout_3(const Message&, Layout&) const;
  void read_chunk_layout_4(const Message&, Layout&) const;
  void check_layout(const Layout&) const;
  void visit_links(std::uint64_t tree, std::uint64_t names, std::uint64_t names_size, unsigned deepest,
                   std::map<std::string, Address>&) const;
  struct Chunk;
  void visit_chunks(std::uint64_t node, unsigned deepest, const Layout&, std::string& out) const;
  void visit_tree_2(const Layout&, std::string& out) const;
  void visit_array(const Layout&, std::string& out) const;
  bool bit_at(std::uint64_t bitmap, std::uint64_t bit) const;
  // Where an array has the entry of a chunk, or kNowhere.
  std::uint64_t fixed_array_entry(const Layout&, std::uint64_t index) const;
  std::uint64_t extensible_array_entry(const Layout&, std::uint64_t index) const;
  void place_chunk(const Chunk&, const Layout&, std::string& out) const;

  const std::string& content_;
  Address root_ = 0;
  mutable std::uint64_t nodes_left_ = 0;   // of trees, which may not have loops
  mutable std::uint64_t chunks_left_ = 0;  // each part of a dataset is stored once
};

}  // namespace terrazzo
