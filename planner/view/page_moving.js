// Moving obstacles, placed at the time of the time bar.

const WHOLE = new THREE.Vector3(1, 1, 1);

// Interpolation on a line and about one axis, as in planner.robot.moving; at rest before the first and after the last pose.
function poseAt(item, seconds) {
  const last = item.times.length - 1;
  let k = 0;
  while (k < last - 1 && item.times[k + 1] <= seconds) k++;
  const next = Math.min(k + 1, last), span = item.times[next] - item.times[k];
  const part = span > 0 ? Math.min(Math.max((seconds - item.times[k]) / span, 0), 1) : 0;
  const place = new THREE.Vector3(...item.positions[k]).lerp(new THREE.Vector3(...item.positions[next]), part);
  const turn = new THREE.Quaternion(...item.quaternions[k]).slerp(new THREE.Quaternion(...item.quaternions[next]), part);
  return new THREE.Matrix4().compose(place, turn, WHOLE);
}

function placeMoving(path, share) {
  const seconds = path.motion ? path.motion.begin + share * path.motion.duration : 0;
  data.moving.forEach((item, k) => viewer.set_transform(["meshcat", "moving", String(k)], poseAt(item, seconds).toArray()));
  viewer.set_dirty();
}
