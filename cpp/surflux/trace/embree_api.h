#pragma once

// Every difference between Embree 3 and 4, and nothing else. Included by trace's .cpp files alone.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#define SURFLUX_EMBREE 4
#else
#include <embree3/rtcore.h>
#define SURFLUX_EMBREE 3
#endif

namespace surflux::embree {

#if SURFLUX_EMBREE == 4

using Context = RTCRayQueryContext;

inline void init(Context& context) { rtcInitRayQueryContext(&context); }

inline void occluded(RTCScene scene, Context& context, RTCRay& ray) {
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &context;
    rtcOccluded1(scene, &ray, &arguments);
}

inline void intersect(RTCScene scene, Context& context, RTCRayHit& hit) {
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context;
    rtcIntersect1(scene, &hit, &arguments);
}

inline void occluded(const int (&valid)[16], RTCScene scene, Context& context, RTCRay16& rays) {
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &context;
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    rtcOccluded16(valid, scene, &rays, &arguments);
}

inline void intersect(const int (&valid)[16], RTCScene scene, Context& context, RTCRayHit16& hits) {
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context;
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    rtcIntersect16(valid, scene, &hits, &arguments);
}

#else

using Context = RTCIntersectContext;

inline void init(Context& context) { rtcInitIntersectContext(&context); }

inline void occluded(RTCScene scene, Context& context, RTCRay& ray) { rtcOccluded1(scene, &context, &ray); }

inline void intersect(RTCScene scene, Context& context, RTCRayHit& hit) { rtcIntersect1(scene, &context, &hit); }

inline void occluded(const int (&valid)[16], RTCScene scene, Context& context, RTCRay16& rays) {
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcOccluded16(valid, scene, &context, &rays);
}

inline void intersect(const int (&valid)[16], RTCScene scene, Context& context, RTCRayHit16& hits) {
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(valid, scene, &context, &hits);
}

#endif

// Embree 4 checks ray masks by default and starts a geometry's mask at 1; with all bits set on both sides, masks hide
// nothing in either version.
constexpr unsigned mask_all = 0xffffffffu;

}  // namespace surflux::embree
