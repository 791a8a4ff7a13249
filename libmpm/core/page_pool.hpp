#pragma once
/// Memory of the particles: pages of 32 records of one size, cut from slabs that are aligned to huge pages.

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

namespace mpm {

inline constexpr int page_particles = 32;  ///< particles of a page

/// Pages are handed out in any order by several threads; which address a page has never influences a result.
class PagePool {
 public:
  /// @param record_bytes  size of a record, a multiple of its alignment
  explicit PagePool(std::size_t record_bytes) : page_bytes_(page_particles * record_bytes) {}
  PagePool(const PagePool&) = delete;
  PagePool& operator=(const PagePool&) = delete;

  /// A page of zeros, aligned to 64 bytes. @throws std::bad_alloc
  std::byte* take();
  /// @param page  from take() of this pool
  void give_back(std::byte* page);
  [[nodiscard]] std::size_t bytes() const { return slabs_.size() * slab_bytes; }  ///< of all slabs, in use or not

 private:
  static constexpr std::size_t slab_bytes = std::size_t{2} << 20;
  struct Unmap {
    void operator()(std::byte* p) const;
  };
  std::size_t page_bytes_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<std::byte[], Unmap>> slabs_;
  std::vector<std::byte*> free_;
};

}  // namespace mpm
