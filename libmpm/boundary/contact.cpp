#include "libmpm/boundary/contact.hpp"

namespace mpm {

Vec3 contact_velocity(const Vec3& velocity, const Vec3& normal, const Vec3& surface_velocity, Contact contact, double friction) {
  if (contact == Contact::no_slip) return surface_velocity;
  const Vec3 relative = velocity - surface_velocity;
  const double approach = relative.dot(normal);
  if (approach >= 0.0 && contact == Contact::separable) return velocity;
  Vec3 tangential = relative - approach * normal;
  if (friction > 0.0 && approach < 0.0) {
    const double speed = tangential.norm();
    const double loss = -friction * approach;
    tangential *= speed > loss ? 1.0 - loss / speed : 0.0;
  }
  return surface_velocity + tangential;
}

}  // namespace mpm
