#include "nodes/common/io/hdf5/hdf5_input.h"

#include <algorithm>

#include "nodes/common/io/hdf5/hdf5_errors.h"
#include "nodes/common/io/hdf5/hdf5_layout.h"

// HDF5 File Format Specification, version 3.0
namespace terrazzo {
namespace {

std::uint64_t padded(std::uint64_t size) { return (size + 7) / 8 * 8; }

}  // namespace

bool Hdf5Input::is_hdf5(const std::string& beginning) {
  return beginning.compare(0, 8, "\x89HDF\r\n\x1a\n") == 0;
}

void Hdf5Input::require(std::uint64_t at, std::uint64_t bytes) const {
  if (at > content_.size() || bytes > content_.size() - at)
    hdf5_damaged("the HDF5 file ends early or has a wrong address in it");
}

std::uint64_t Hdf5Input::number(std::uint64_t at, unsigned bytes) const {
  require(at, bytes);
  std::uint64_t v = 0;
  for (unsigned i = bytes; i-- > 0;) v = v << 8 | static_cast<unsigned char>(content_[at + i]);
  return v;
}

void Hdf5Input::require_text(std::uint64_t at, const char* expected) const {
  require(at, 4);
  if (content_.compare(at, 4, expected) != 0)
    hdf5_damaged(std::string("the HDF5 file has no ") + expected + " where one should be");
}

Hdf5Input::Hdf5Input(const std::string& content) : content_(content) {
  if (!is_hdf5(content_)) hdf5_damaged("the file does not begin like HDF5");
  root_ = root_of_superblock();
  if (!is_group(root_)) hdf5_damaged("the HDF5 file has no root group");
}

Hdf5Input::Address Hdf5Input::root_of_superblock() const {
  const std::uint64_t version = number(8, 1);
  if (version > 3)
    hdf5_unsupported("the HDF5 file uses version " + std::to_string(version) +
                     " of the superblock; supported are 0 to 3");
  const bool newer = version >= 2;
  const std::uint64_t sizes = newer ? 9 : 13;
  if (number(sizes, 1) != 8 || number(sizes + 1, 1) != 8)
    hdf5_unsupported("the HDF5 file has addresses of other than 8 bytes");
  if (newer) require(0, number(28, 8));  // the file's length
  const std::uint64_t base = newer ? 12 : version == 0 ? 24 : 28;
  if (number(base, 8) != 0) hdf5_unsupported("the HDF5 file has a base address");
  return number(newer ? 36 : base + 32 + 8, 8);
}

std::vector<Hdf5Input::Message> Hdf5Input::messages(Address object) const {
  require(object, 16);
  return content_.compare(object, 4, "OHDR") == 0 ? messages_2(object) : messages_1(object);
}

void Hdf5Input::add_message(const Message& m, std::uint64_t flags, std::vector<Message>& out) {
  if (!(flags & 2)) {
    out.push_back(m);
    return;
  }
  if (m.type == 1 || m.type == 3 || m.type == 0xb)
    hdf5_unsupported("the HDF5 file shares types between objects", "write it without named data types");
}

std::vector<Hdf5Input::Message> Hdf5Input::messages_1(Address object) const {
  if (number(object, 1) != 1) hdf5_damaged("the HDF5 file has an object header of an unknown version");
  std::uint64_t left = number(object + 2, 2);
  std::vector<std::pair<std::uint64_t, std::uint64_t>> blocks = {{object + 16, number(object + 8, 4)}};
  std::vector<Message> out;
  for (std::size_t b = 0; b < blocks.size() && left > 0; ++b) {
    auto [at, size] = blocks[b];
    require(at, size);
    while (size >= 8 && left > 0) {
      const Message m{static_cast<unsigned>(number(at, 2)), at + 8, number(at + 2, 2)};
      if (m.size > size - 8) hdf5_damaged("a message of the HDF5 file is too long");
      --left;
      if (m.type == 0x10) {  // continued elsewhere
        if (m.size < 16) hdf5_damaged("a message of the HDF5 file is too short");
        blocks.emplace_back(number(m.at, 8), number(m.at + 8, 8));
      } else {
        add_message(m, number(at + 4, 1), out);
      }
      at += 8 + m.size;
      size -= 8 + m.size;
    }
  }
  return out;
}

std::vector<Hdf5Input::Message> Hdf5Input::messages_2(Address object) const {
  if (number(object + 4, 1) != 2) hdf5_damaged("the HDF5 file has an object header of an unknown version");
  const std::uint64_t flags = number(object + 5, 1);
  const std::uint64_t size_at = object + 6 + (flags & 0x20 ? 16 : 0) + (flags & 0x10 ? 4 : 0);
  const unsigned size_bytes = 1 << (flags & 3);
  const std::uint64_t head = flags & 4 ? 6 : 4;  // of a message
  std::vector<std::pair<std::uint64_t, std::uint64_t>> blocks = {
      {size_at + size_bytes, number(size_at, size_bytes)}};
  std::vector<Message> out;
  std::uint64_t seen = 0;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    auto [at, size] = blocks[b];
    require(at, size);
    seen += size + head;
    if (seen > content_.size()) hdf5_damaged("an object header of the HDF5 file contains itself");
    while (size >= head) {
      const Message m{static_cast<unsigned>(number(at, 1)), at + head, number(at + 1, 2)};
      if (m.size > size - head) hdf5_damaged("a message of the HDF5 file is too long");
      if (m.type == 0x10) {  // continued elsewhere, between a signature and a checksum
        if (m.size < 16) hdf5_damaged("a message of the HDF5 file is too short");
        const std::uint64_t block = number(m.at, 8), length = number(m.at + 8, 8);
        require_text(block, "OCHK");
        if (length < 8) hdf5_damaged("a part of an object header of the HDF5 file is too short");
        blocks.emplace_back(block + 4, length - 8);
      } else {
        add_message(m, number(at + 3, 1), out);
      }
      at += head + m.size;
      size -= head + m.size;
    }
  }
  return out;
}

bool Hdf5Input::is_group(Address object) const {
  const auto all = messages(object);
  return std::any_of(all.begin(), all.end(),
                     [](const Message& m) { return m.type == 0x11 || m.type == 0x02 || m.type == 0x06; });
}

std::map<std::string, Hdf5Input::Address> Hdf5Input::children(Address group) const {
  std::map<std::string, Address> out;
  for (const Message& m : messages(group)) {
    if (m.type == 0x06) add_link(m, out);
    if (m.type == 0x02) {
      const std::uint64_t heap = m.at + (number(m.at + 1, 1) & 1 ? 10 : 2);
      if (number(heap, 8) != kNowhere)
        for (const Message& link : heap_objects(number(heap, 8), number(heap + 8, 8), 5)) add_link(link, out);
    }
    if (m.type != 0x11) continue;
    if (m.size < 16) hdf5_damaged("a message of the HDF5 file is too short");
    const std::uint64_t heap = number(m.at + 8, 8);
    require_text(heap, "HEAP");
    const std::uint64_t size = number(heap + 8, 8), names = number(heap + 24, 8);
    require(names, size);
    nodes_left_ = content_.size() / 24;
    visit_links(number(m.at, 8), names, size, 16, out);
  }
  return out;
}

// Symbolic and external links are left out.
void Hdf5Input::add_link(const Message& m, std::map<std::string, Address>& out) const {
  if (number(m.at, 1) != 1) hdf5_damaged("the HDF5 file has a link of an unknown version");
  const std::uint64_t flags = number(m.at + 1, 1);
  std::uint64_t at = m.at + 2;
  const bool hard = !(flags & 8) || number(at, 1) == 0;
  at += (flags & 8 ? 1 : 0) + (flags & 4 ? 8 : 0) + (flags & 16 ? 1 : 0);
  const unsigned length_bytes = 1 << (flags & 3);
  const std::uint64_t length = number(at, length_bytes);
  at += length_bytes;
  require(at, length);
  if (length > m.size || at + length + (hard ? 8 : 0) > m.at + m.size)
    hdf5_damaged("a link of the HDF5 file is too long");
  if (!hard) return;
  const Address object = number(at + length, 8);
  require(object, 16);
  out[content_.substr(at, length)] = object;
}

void Hdf5Input::visit_links(std::uint64_t node, std::uint64_t names, std::uint64_t names_size,
                            unsigned deepest, std::map<std::string, Address>& out) const {
  if (nodes_left_-- == 0 || deepest == 0) hdf5_damaged("a group of the HDF5 file contains itself");
  require(node, 8);
  if (content_.compare(node, 4, "SNOD") == 0) {
    const std::uint64_t count = number(node + 6, 2);
    for (std::uint64_t k = 0; k < count; ++k) {
      const std::uint64_t entry = node + 8 + 40 * k, name = number(entry, 8), object = number(entry + 8, 8);
      if (name >= names_size) hdf5_damaged("a name in the HDF5 file is missing");
      const std::size_t begin = names + name, end = content_.find('\0', begin);
      if (end == std::string::npos || end >= names + names_size)
        hdf5_damaged("a name in the HDF5 file has no end");
      if (number(entry + 16, 4) == 2) continue;  // a symbolic link
      require(object, 16);
      out[content_.substr(begin, end - begin)] = object;
    }
    return;
  }
  require_text(node, "TREE");
  if (number(node + 4, 1) != 0) hdf5_damaged("a group of the HDF5 file has a tree of another kind");
  const std::uint64_t count = number(node + 6, 2);
  for (std::uint64_t k = 0; k < count; ++k)
    visit_links(number(node + 32 + 16 * k, 8), names, names_size, deepest - 1, out);
}

Hdf5Input::Address Hdf5Input::find(const std::string& path) const {
  Address at = root_;
  for (std::size_t begin = 1; begin < path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    if (!is_group(at)) return 0;
    const auto all = children(at);
    const auto it = all.find(path.substr(begin, end - begin));
    if (it == all.end()) return 0;
    at = it->second;
    begin = end + 1;
  }
  return at;
}

std::vector<Hdf5Input::Message> Hdf5Input::attributes(Address object) const {
  std::vector<Message> out;
  for (const Message& m : messages(object)) {
    if (m.type == 0x0c) out.push_back(m);
    if (m.type != 0x15) continue;
    const std::uint64_t heap = m.at + (number(m.at + 1, 1) & 1 ? 4 : 2);
    if (number(heap, 8) == kNowhere) continue;
    const auto more = heap_objects(number(heap, 8), number(heap + 8, 8), 8);
    out.insert(out.end(), more.begin(), more.end());
  }
  return out;
}

bool Hdf5Input::attribute(Address object, const std::string& name, Hdf5Array& array,
                          std::string& bytes) const {
  for (const Message& m : attributes(object)) {
    const std::uint64_t version = number(m.at, 1);
    if (version < 1 || version > 3) hdf5_damaged("an attribute of the HDF5 file has an unknown version");
    const auto room = [&](std::uint64_t size) { return version == 1 ? padded(size) : size; };
    const std::uint64_t name_size = number(m.at + 2, 2), type_size = number(m.at + 4, 2),
                        space_size = number(m.at + 6, 2);
    const std::uint64_t at = m.at + (version == 3 ? 9 : 8), type = at + room(name_size),
                        space = type + room(type_size), data = space + room(space_size);
    if (data > m.at + m.size) hdf5_damaged("an attribute of the HDF5 file is too short");
    if (std::string(content_.data() + at, std::min<std::size_t>(name_size, content_.size() - at)).c_str() !=
        name)
      continue;
    if (number(m.at + 1, 1) & 3 && version > 1)
      hdf5_unsupported("the HDF5 file shares types between objects", "write it without named data types");
    read_type({3, type, type_size}, array);
    read_space({1, space, space_size}, array);
    const std::uint64_t size = array.count() * array.bytes;
    if (size > m.at + m.size - data) hdf5_damaged("an attribute of the HDF5 file is too short");
    bytes = content_.substr(data, size);
    turn_bytes(array, bytes);
    return true;
  }
  return false;
}

}  // namespace terrazzo
