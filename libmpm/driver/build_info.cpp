#include "libmpm/driver/build_info.hpp"

#include "mpm_commit.hpp"  // generated at build time by cmake/WriteCommit.cmake: MPM_COMMIT

namespace mpm {

namespace {
#if defined(__clang__)
constexpr std::string_view compiler = "Clang " __clang_version__;
#else
constexpr std::string_view compiler = "GCC " __VERSION__;
#endif

#if defined(__AVX512F__)
constexpr std::string_view instruction_set = "AVX-512";
constexpr int simd_width_bits = 512;
#elif defined(__AVX2__)
constexpr std::string_view instruction_set = "AVX2";
constexpr int simd_width_bits = 256;
#elif defined(__AVX__)
constexpr std::string_view instruction_set = "AVX";
constexpr int simd_width_bits = 256;
#else
constexpr std::string_view instruction_set = "128-bit";
constexpr int simd_width_bits = 128;
#endif
}  // namespace

BuildInfo build_info() { return {MPM_VERSION, MPM_COMMIT, compiler, MPM_BUILD_TYPE, instruction_set, simd_width_bits}; }

}  // namespace mpm
