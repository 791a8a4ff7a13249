#include "validation/harness/sundials.hpp"

#include <cvode/cvode.h>
#include <fmt/format.h>
#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <exception>
#include <sundials/sundials_context.hpp>

#include "libmpm/base/error.hpp"

namespace mpm::validation {
namespace {

/// The last message of a SUNDIALS package, which would otherwise go to stderr.
void keep_message(int, const char* module, const char* function, char* message, void* to) {
  *static_cast<std::string*>(to) = fmt::format("{} {}: {}", module, function, message);
}

}  // namespace

// Outside the unnamed namespace, because a class that the header declares has such a member.
struct SundialsVectorDeleter {
  void operator()(N_Vector v) const { N_VDestroy(v); }
};
using SundialsVector = std::unique_ptr<std::remove_pointer_t<N_Vector>, SundialsVectorDeleter>;

static SundialsVector make_vector(std::size_t n, SUNContext context) {
  return SundialsVector(N_VNew_Serial(static_cast<sunindextype>(n), context));
}

struct OdeIntegrator::Impl {
  sundials::Context context;
  Rhs rhs;
  Roots roots;
  std::string message;
  std::exception_ptr error;
  SundialsVector y;
  void* memory = nullptr;
  SUNNonlinearSolver solver = nullptr;
  std::size_t unknowns;
  long steps_before = 0;  // CVODE's counter starts anew with every start()

  static int call_rhs(sunrealtype t, N_Vector y, N_Vector dydt, void* self) {
    auto& me = *static_cast<Impl*>(self);
    try {
      me.rhs(t, N_VGetArrayPointer(y), N_VGetArrayPointer(dydt));
      return 0;
    } catch (...) {  // C lies between here and advance()
      me.error = std::current_exception();
      return -1;
    }
  }
  static int call_roots(sunrealtype t, N_Vector y, sunrealtype* g, void* self) {
    auto& me = *static_cast<Impl*>(self);
    try {
      me.roots(t, N_VGetArrayPointer(y), g);
      return 0;
    } catch (...) {
      me.error = std::current_exception();
      return -1;
    }
  }
  void require(int flag) const {
    if (error) std::rethrow_exception(error);
    if (flag < 0) throw UnstableError(fmt::format("reference integration stopped: {}", message));
  }
  [[nodiscard]] long current_steps() const {
    long n = 0;
    CVodeGetNumSteps(memory, &n);
    return n;
  }
  ~Impl() {
    if (memory) CVodeFree(&memory);
    if (solver) SUNNonlinSolFree(solver);
  }
};

OdeIntegrator::OdeIntegrator(std::size_t unknowns, Rhs rhs, double relative_tolerance, double absolute_tolerance)
    : impl_(std::make_unique<Impl>()) {
  Impl& m = *impl_;
  m.unknowns = unknowns;
  m.rhs = std::move(rhs);
  m.y = make_vector(unknowns, m.context);
  N_VConst(0.0, m.y.get());
  m.memory = CVodeCreate(CV_ADAMS, m.context);
  m.require(CVodeSetErrHandlerFn(m.memory, keep_message, &m.message));
  m.require(CVodeInit(m.memory, Impl::call_rhs, 0.0, m.y.get()));
  m.require(CVodeSStolerances(m.memory, relative_tolerance, absolute_tolerance));
  m.require(CVodeSetUserData(m.memory, &m));
  m.solver = SUNNonlinSol_FixedPoint(m.y.get(), 0, m.context);
  m.require(CVodeSetNonlinearSolver(m.memory, m.solver));
  m.require(CVodeSetMaxNumSteps(m.memory, 1000000));
}
OdeIntegrator::~OdeIntegrator() = default;

void OdeIntegrator::start(double t, std::span<const double> y, double stop_time, Roots roots, std::vector<int> directions,
                          double longest_step) {
  Impl& m = *impl_;
  m.steps_before += m.current_steps();
  m.roots = std::move(roots);
  std::copy(y.begin(), y.end(), N_VGetArrayPointer(m.y.get()));
  m.require(CVodeReInit(m.memory, t, m.y.get()));
  m.require(CVodeSetStopTime(m.memory, stop_time));
  m.require(CVodeSetMaxStep(m.memory, longest_step));
  m.require(CVodeRootInit(m.memory, static_cast<int>(directions.size()), directions.empty() ? nullptr : Impl::call_roots));
  if (!directions.empty()) m.require(CVodeSetRootDirection(m.memory, directions.data()));
  m.require(CVodeSetNoInactiveRootWarn(m.memory));
}

OdeIntegrator::Stop OdeIntegrator::advance(double target) {
  Impl& m = *impl_;
  sunrealtype t = 0.0;
  const int flag = CVode(m.memory, target, m.y.get(), &t, CV_NORMAL);
  m.require(flag);
  if (flag != CV_ROOT_RETURN) return {t, -1};
  std::vector<int> found(16, 0);
  m.require(CVodeGetRootInfo(m.memory, found.data()));
  for (std::size_t i = 0; i < found.size(); ++i)
    if (found[i] != 0) return {t, static_cast<int>(i)};
  return {t, -1};
}

std::span<const double> OdeIntegrator::state() const { return {N_VGetArrayPointer(impl_->y.get()), impl_->unknowns}; }
long OdeIntegrator::steps() const { return impl_->steps_before + impl_->current_steps(); }

std::vector<std::vector<double>> integrate_dae(const Residual& residual, const Jacobian& jacobian, double t0, std::vector<double> y,
                                               std::vector<double> dydt, std::span<const double> times, double relative_tolerance,
                                               double absolute_tolerance) {
  struct Problem {
    const Residual& residual;
    const Jacobian& jacobian;
    std::exception_ptr error;
    std::string message;
    std::vector<double> rows;
  } problem{residual, jacobian, nullptr, {}, std::vector<double>(y.size() * y.size())};
  sundials::Context context;
  const std::size_t n = y.size();
  const SundialsVector state = make_vector(n, context), slope = make_vector(n, context);
  std::copy(y.begin(), y.end(), N_VGetArrayPointer(state.get()));
  std::copy(dydt.begin(), dydt.end(), N_VGetArrayPointer(slope.get()));
  const auto call = [](sunrealtype t, N_Vector a, N_Vector b, N_Vector r, void* self) -> int {
    auto& p = *static_cast<Problem*>(self);
    try {
      p.residual(t, N_VGetArrayPointer(a), N_VGetArrayPointer(b), N_VGetArrayPointer(r));
      return 0;
    } catch (...) {
      p.error = std::current_exception();
      return -1;
    }
  };
  const auto call_jacobian = [](sunrealtype t, sunrealtype c, N_Vector a, N_Vector b, N_Vector, SUNMatrix m, void* self, N_Vector, N_Vector,
                                N_Vector) -> int {
    auto& p = *static_cast<Problem*>(self);
    try {
      p.jacobian(t, c, N_VGetArrayPointer(a), N_VGetArrayPointer(b), p.rows.data());
    } catch (...) {
      p.error = std::current_exception();
      return -1;
    }
    const auto size = static_cast<sunindextype>(N_VGetLength(a));
    for (sunindextype i = 0; i < size; ++i)
      for (sunindextype j = 0; j < size; ++j) SM_ELEMENT_D(m, i, j) = p.rows[static_cast<std::size_t>(i * size + j)];
    return 0;
  };
  struct Resources {
    void* memory;
    SUNMatrix matrix = nullptr;
    SUNLinearSolver solver = nullptr;
    ~Resources() {
      if (memory) IDAFree(&memory);
      if (solver) SUNLinSolFree(solver);
      if (matrix) SUNMatDestroy(matrix);
    }
  } r{IDACreate(context)};
  const auto require = [&](int flag) {
    if (problem.error) std::rethrow_exception(problem.error);
    if (flag < 0) throw UnstableError(fmt::format("reference integration stopped: {}", problem.message));
  };
  require(IDASetErrHandlerFn(r.memory, keep_message, &problem.message));
  require(IDAInit(r.memory, call, t0, state.get(), slope.get()));
  require(IDASStolerances(r.memory, relative_tolerance, absolute_tolerance));
  require(IDASetUserData(r.memory, &problem));
  const auto size = static_cast<sunindextype>(n);
  r.matrix = SUNDenseMatrix(size, size, context);
  r.solver = SUNLinSol_Dense(state.get(), r.matrix, context);
  require(IDASetLinearSolver(r.memory, r.solver, r.matrix));
  require(IDASetJacFn(r.memory, call_jacobian));
  require(IDASetMaxNumSteps(r.memory, 20000));
  require(IDASetStopTime(r.memory, times.back()));
  std::vector<std::vector<double>> result;
  for (const double target : times) {
    sunrealtype t = 0.0;
    require(IDASolve(r.memory, target, &t, state.get(), slope.get(), IDA_NORMAL));
    const double* s = N_VGetArrayPointer(state.get());
    result.emplace_back(s, s + n);
  }
  return result;
}

}  // namespace mpm::validation
