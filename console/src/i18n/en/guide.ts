export default {
  'guide.title': 'First steps',
  'guide.leave': 'Leave the guide',
  'guide.start': 'Begin',
  'guide.next': 'Next',
  'guide.skip': 'Skip',
  'guide.finish': 'Done',
  'guide.well': 'Done',
  'guide.break': 'Break my link',
  'guide.heat': 'Heat of the fires: {heat}',
  'guide.welcome_title': 'A tank farm is on fire',
  'guide.welcome':
    'Three simulated monitors stand around it, with the very software of real ones. In two minutes you will have put water on the fire, by hand and automatically.',
  'guide.not_yet': 'Do this step first, or skip it.',
  'guide.welcome_calm_title': 'A tank farm',
  'guide.welcome_calm':
    'Three simulated monitors surround it, with the very software of real ones. In two minutes you will have aimed water at a tank, by hand and automatically.',
  'guide.fire_calm_title': 'Bring the water to a tank',
  'guide.fire_calm': 'Press Aim and then a tank on the plan: the barrel is raised so that the jet falls there. Or steer by hand.',
  'guide.control_title': 'Take control',
  'guide.control':
    'One person at a time commands a monitor. Press Take control above. STOP, Close and LOCKOUT need none: they always work, for everybody.',
  'guide.deploy_title': 'Deploy the barrel',
  'guide.deploy': 'It stands wrapped and protected. Press Deploy and watch it come up; until then it neither moves nor opens.',
  'guide.move_title': 'Hold to move',
  'guide.move':
    'Hold the stick, or an arrow key. The barrel moves for as long as you hold: let go, leave the window or lose the link, and it stops.',
  'guide.open_title': 'Open the water',
  'guide.open': 'Hold Open for a second, so that nobody opens it by accident. One press of Close closes it.',
  'guide.fire_title': 'Bring the water to the fire',
  'guide.fire': 'Press Aim and then the burning tank on the plan: the barrel is raised so that the jet falls there. Or steer by hand. Wind bends the jet; a wider one reaches less far.',
  'guide.auto_title': 'Now let it work by itself',
  'guide.auto':
    'Press Draw sector, drag over the burning tank on the plan, press Extinguish. The jet sweeps the sector line by line; if you steer, it waits, and goes on 3 s later.',
  'guide.link_title': 'And when the link breaks?',
  'guide.link':
    'Try it. Values turn grey and show their age, nothing can be sent, what you hold stops within 300 ms. The program goes on: a fire is not left because a browser has crashed.',
  'guide.end_title': 'That is the first minute',
  'guide.end':
    'Try STOP and LOCKOUT, 3D, the other monitors, the search for fire. Press ? for the keys. The guide is in Help if you want it again.',
};
