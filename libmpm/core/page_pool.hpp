#pragma once
/// Memory of the particles: pages of 32 records, cut from huge-page aligned slabs, handed out and taken back.

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "libmpm/core/particle.hpp"

namespace mpm {

inline constexpr int page_particles = 32;  ///< particles of a page

/// What the pool hands out: 6 kB.
struct ParticlePage {
  Particle slot[page_particles];  ///< records; which of them count, the bin knows
};

/// Pages are handed out in any order by several threads; which address a page has never influences a result.
class PagePool {
 public:
  PagePool() = default;
  PagePool(const PagePool&) = delete;
  PagePool& operator=(const PagePool&) = delete;

  /// A page whose content is unspecified but finite. @throws std::bad_alloc
  ParticlePage* take();
  /// @param page  from take() of this pool
  void give_back(ParticlePage* page);
  [[nodiscard]] std::size_t bytes() const { return slabs_.size() * slab_bytes; }  ///< of all slabs, in use or not

 private:
  static constexpr std::size_t slab_bytes = std::size_t{2} << 20;
  struct Unmap {
    void operator()(std::byte* p) const;
  };
  std::mutex mutex_;
  std::vector<std::unique_ptr<std::byte[], Unmap>> slabs_;
  std::vector<ParticlePage*> free_;
};

}  // namespace mpm
