#include "scan/units/content_hash.h"

#include <array>
#include <new>

// SHA-256 and no faster hash without cryptography: units may come from other people's machines, and
// nobody can make another content of the same key. What it costs: docs/cache.md.
#include <openssl/evp.h>

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
  EVP_DigestUpdate(digest_->context, bytes, count);
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
