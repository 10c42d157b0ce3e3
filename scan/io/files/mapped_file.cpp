#include "scan/io/files/mapped_file.h"

#include <cerrno>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "scan/base/system/file_descriptor.h"
#include "scan/io/files/io_error.h"

namespace relief {

Result<MappedFile> MappedFile::open(const std::filesystem::path& path) {
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.is_open()) return bad_input(path, std::string("cannot open: ") + std::strerror(errno));
  struct stat status {};
  if (::fstat(file.get(), &status) != 0)
    return bad_input(path, std::string("cannot read: ") + std::strerror(errno));
  if (!S_ISREG(status.st_mode)) return bad_input(path, "this is a folder or device, not a file");
  MappedFile mapped;
  if (status.st_size == 0) return mapped;
  mapped.size_ = static_cast<std::size_t>(status.st_size);
  void* data = ::mmap(nullptr, mapped.size_, PROT_READ, MAP_PRIVATE, file.get(), 0);
  if (data == MAP_FAILED)
    return bad_input(path, std::string("cannot map to memory: ") + std::strerror(errno));
  mapped.data_ = static_cast<const char*>(data);
  return mapped;
}

MappedFile::~MappedFile() {
  if (data_) ::munmap(const_cast<char*>(data_), size_);
}

void MappedFile::release_before(std::size_t end) const {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  if (data_) ::madvise(const_cast<char*>(data_), end / page * page, MADV_DONTNEED);
}

}  // namespace relief
