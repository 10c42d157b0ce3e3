#include "scan/units/content_hash.h"

#include <algorithm>
#include <array>
#include <new>

// SHA-256 and no faster hash without cryptography: units may come from other people's machines, and
// nobody can make another content of the same key. What it costs: docs/cache.md.
#include <openssl/evp.h>

#include "scan/base/parallel.h"

namespace relief {

struct ContentHash::Digest {
  Digest() : context(EVP_MD_CTX_new()) {
    if (context == nullptr || EVP_DigestInit_ex(context, EVP_sha256(), nullptr) != 1)
      throw std::bad_alloc();
  }
  Digest(const Digest&) = delete;
  Digest& operator=(const Digest&) = delete;
  ~Digest() { EVP_MD_CTX_free(context); }

  EVP_MD_CTX* context;
};

ContentHash::ContentHash() : digest_(std::make_unique<Digest>()) {}
ContentHash::~ContentHash() = default;
ContentHash::ContentHash(ContentHash&&) noexcept = default;
ContentHash& ContentHash::operator=(ContentHash&&) noexcept = default;

ContentHash& ContentHash::add_bytes(const void* bytes, std::size_t count) {
  constexpr std::size_t kPiece = std::size_t{4} << 20;  // Between looks; changes no result.
  const auto* const first = static_cast<const unsigned char*>(bytes);
  for (std::size_t at = 0; at < count; at += kPiece) {
    if (at > 0) check_stop_and_memory();
    EVP_DigestUpdate(digest_->context, first + at, std::min(kPiece, count - at));
  }
  return *this;
}

std::string ContentHash::hex() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
  unsigned count = 0;
  EVP_DigestFinal_ex(digest_->context, bytes.data(), &count);
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (unsigned i = 0; i < count; ++i) {
    text += kDigits[bytes[i] >> 4];
    text += kDigits[bytes[i] & 15];
  }
  return text;
}

}  // namespace relief
