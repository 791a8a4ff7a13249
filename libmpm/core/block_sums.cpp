#include "libmpm/core/block_sums.hpp"

#include <algorithm>

namespace mpm {

void BlockSums::add_ranks(RankGroup& ranks) {
  constexpr std::size_t words = ExactSum::words;
  std::vector<std::uint64_t> all(words * sums_.size());
  for (std::size_t i = 0; i < sums_.size(); ++i) std::ranges::copy(sums_[i].parts(), all.begin() + static_cast<std::ptrdiff_t>(words * i));
  ranks.sum(all);
  for (std::size_t i = 0; i < sums_.size(); ++i)
    std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(words * i), words, sums_[i].parts().begin());
}

}  // namespace mpm
