export default {
  'guide.title': 'First steps',
  'guide.leave': 'Leave the guide',
  'guide.start': 'Start',
  'guide.next': 'Next',
  'guide.skip': 'Skip',
  'guide.finish': 'Done',
  'guide.well': 'Done',
  'guide.break': 'Break my connection',
  'guide.heat': 'Heat of the fires: {heat}',
  'guide.welcome_title': 'A tank farm is on fire',
  'guide.welcome':
    'Three simulated monitors surround it, running the same software as real ones. In two minutes you will have put water on the fire, by hand and automatically.',
  'guide.not_yet': 'Complete this step first, or skip it.',
  'guide.welcome_calm_title': 'A tank farm',
  'guide.welcome_calm':
    'Three simulated monitors surround it, running the same software as real ones. In two minutes you will have aimed water at a tank, by hand and automatically.',
  'guide.fire_calm_title': 'Bring the water to a tank',
  'guide.fire_calm':
    'Press Aim and then a tank on the plan: the barrel is raised so that the jet falls there. Or steer by hand.',
  'guide.control_title': 'Take control',
  'guide.control':
    'One operator at a time commands a monitor. Press Take control above. STOP, Close and LOCKOUT do not need control: they always work, for every user.',
  'guide.deploy_title': 'Deploy the barrel',
  'guide.deploy': 'It is stowed and protected. Press Deploy and watch it rise; until then it neither moves nor opens.',
  'guide.move_title': 'Hold to move',
  'guide.move':
    'Hold the joystick, or an arrow key. The barrel moves for as long as you hold: release it, leave the window or lose the connection, and it stops.',
  'guide.open_title': 'Open the water',
  'guide.open': 'Hold Open for a second: this prevents opening by accident. One press of Close closes it.',
  'guide.fire_title': 'Bring the water to the fire',
  'guide.fire':
    'Press Aim and then the burning tank on the plan: the barrel is raised so that the jet falls there. Or steer by hand. Wind bends the jet; a wider one reaches less far.',
  'guide.auto_title': 'Now automatically',
  'guide.auto':
    'Press Draw sector, drag over the burning tank on the plan, press Extinguish. The jet scans the sector line by line; if you steer, it pauses, and continues 3 s later.',
  'guide.link_title': 'What if the connection is lost?',
  'guide.link':
    'Try it. Values turn grey and show their age, no command can be sent, a motion that you hold stops within 300 ms. The program continues: a fire is not abandoned because a browser has crashed.',
  'guide.end_title': 'First steps completed',
  'guide.end':
    'Try STOP and LOCKOUT, 3D, the other monitors, the search for fire. Press ? for the keys. The guide can be repeated from Help.',
};
