#include <cstring>
#include <fstream>
#include <sstream>
#include <string_view>

#include <link.h>

#include "scan/units/content_hash.h"

namespace relief {

namespace {

constexpr std::size_t aligned(std::size_t size) { return (size + 3) & ~std::size_t{3}; }

// The descriptor of the note NT_GNU_BUILD_ID in a segment of notes; empty: it has none.
std::string_view build_id_in(const char* notes, std::size_t size) {
  std::size_t at = 0;
  while (at + sizeof(ElfW(Nhdr)) <= size) {
    ElfW(Nhdr) note;
    std::memcpy(&note, notes + at, sizeof note);
    const char* name = notes + at + sizeof note;
    const char* descriptor = name + aligned(note.n_namesz);
    if (note.n_type == NT_GNU_BUILD_ID && note.n_namesz == 4 && std::memcmp(name, "GNU", 4) == 0)
      return {descriptor, note.n_descsz};
    at += sizeof note + aligned(note.n_namesz) + aligned(note.n_descsz);
  }
  return {};
}

std::string_view build_id_of(const dl_phdr_info& object) {
  for (int i = 0; i < object.dlpi_phnum; ++i) {
    const auto& segment = object.dlpi_phdr[i];
    if (segment.p_type != PT_NOTE) continue;
    const auto* notes = reinterpret_cast<const char*>(object.dlpi_addr + segment.p_vaddr);
    if (const auto id = build_id_in(notes, segment.p_memsz); !id.empty()) return id;
  }
  return {};
}

// Linked without a build id: by its bytes.
std::string content_of(const char* name) {
  std::ifstream file(*name ? name : "/proc/self/exe", std::ios::binary);
  std::ostringstream content;
  content << file.rdbuf();
  return std::move(content).str();
}

// Of the program and the libraries that it is linked with. What they load later, such as a thread
// pool's own helpers, depends on the machine; it stands behind them in the list.
int count_object(dl_phdr_info*, std::size_t, void* count) {
  ++*static_cast<std::size_t*>(count);
  return 0;
}

std::size_t count_objects() {
  std::size_t count = 0;
  dl_iterate_phdr(count_object, &count);
  return count;
}

const std::size_t objects_at_start = count_objects();

struct Identity {
  ContentHash hash;
  std::size_t left = objects_at_start;
};

int add_object(dl_phdr_info* object, std::size_t, void* data) {
  auto& identity = *static_cast<Identity*>(data);
  if (identity.left-- == 0) return 1;
  const std::string_view name = object->dlpi_name;
  if (name.rfind("linux-", 0) == 0) return 0;  // Code of the kernel: none of the results is its.
  const std::string_view id = build_id_of(*object);
  if (id.empty())
    identity.hash.add(std::string_view(content_of(object->dlpi_name)));
  else
    identity.hash.add(id);
  return 0;
}

}  // namespace

const std::string& program_identity() {
  static const std::string identity = [] {
    Identity found;
    dl_iterate_phdr(add_object, &found);
    return found.hash.hex();
  }();
  return identity;
}

}  // namespace relief
