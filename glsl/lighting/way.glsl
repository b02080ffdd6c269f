// The way from a point of a triangle to a light, and whether anything blocks it. Decisions only.
#include "geometry/trace.glsl"
#include "geometry/plane.glsl"
#include "geometry/occlusion.glsl"

// No ray is wanted if it is not `asked` for. With `others`, an object does not shadow itself.
Ask way(Light light, uint object, uint face, vec3 origin, bool asked, bool others) {
    bool far = light.kind == LIGHT_DIRECTIONAL || light.kind == LIGHT_SKY_RAY;
    precise vec3 direction = light.place;
    if (!far) direction = light.place - origin;
    uvec3 corner = triangles[face];
    Plane own = plane_of(placed_positions[corner.x], placed_positions[corner.y], placed_positions[corner.z]);

    // A face that is turned away, behind an area light or outside a spot's cone needs no ray.
    float facing = dot3(direction, own.normal);
    float side = facing > 0.0 ? 1.0 : -1.0;
    float along = -dot3(direction, light.axis);
    precise float cosine = 1.0 - light.outer;
    precise float square = along * along;
    precise float least = cosine * cosine * dot3(direction, direction);
    bool shines = (light.kind != LIGHT_AREA || along > 0.0) &&
                  (light.kind != LIGHT_SPOT || (along > 0.0 && square > least));
    bool wanted = asked && shines && (others || facing > 0.0 || (object_params[object].two_sided != 0 && facing < 0.0));
    uvec2 spared = uvec2(object_params[object].first_face, object_params[object].faces);
    return Ask(face, origin, direction, light.place, far, own, side, wanted, others, spared);
}
